#include <cmath>

#include "effect/effects/effects.hpp"

namespace qerr {

namespace {

Term step_at(const RecordSignals& s, double time) {
  Term t =
      linear_term(s, "missed_counts", (s.time >= time).cast<double>() * (direction(s.encoder) * s.step()),
                  [](Effect& e, const Eigen::VectorXd& c) { e.numbers["counts"] = c[0]; });
  t.effect.numbers["time"] = time;
  t.step = t.whole = true;
  return t;
}

}  // namespace

EffectKind missed_counts_effect() {
  return {
      .name = "missed_counts",
      .summary = "counts lost or gained at one time, persistent",
      .typical = "one line (4 counts) per burst of interference",
      .stage = Stage::decoder,
      .parameters = {{.name = "counts",
                      .kind = Kind::integer,
                      .meaning = "counts added to the reading",
                      .required = true,
                      .least = -1e9,
                      .most = 1e9},
                     {.name = "time",
                      .dimension = dimension::time,
                      .meaning = "time of the loss",
                      .required = true,
                      .least = 0}},
      .action = [](const Effect& e, const Encoder&, std::uint64_t) -> Action {
        return [counts = e.number("counts"), time = e.number("time")](double x, const Moment& m) {
          return m.time >= time ? x + counts : x;
        };
      },
      // Zero before the time, the full step after: at an unknown time, mean and deviation are half the step.
      .share = [](const Effect& e, const Encoder& encoder, const Usage&) -> std::optional<Share> {
        const double middle = 0.5 * e.number("counts") * direction(encoder) * encoder.resolution;
        return Share{middle, std::abs(middle), std::abs(middle), Spectrum::motion};
      },
      .step_at = step_at,
      .remedy = {false,
                 "the loss is persistent: check the count at an index pulse; inspect cable and shield"}};
}

}  // namespace qerr
