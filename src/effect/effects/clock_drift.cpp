#include <cmath>
#include <numbers>

#include "effect/effects/effects.hpp"

namespace qerr {

namespace {

std::vector<Term> terms(const RecordSignals& s) {
  if (!s.ordered || s.is_stationary()) return {};
  return {linear_term(s, "clock_drift", s.time * s.joint_rate(),
                      [](Effect& e, const Eigen::VectorXd& c) { e.numbers["rate"] = c[0]; })};
}

/// rate t v(t), with t uniform over the duration and independent of v.
std::optional<Share> share(const Effect& e, const Encoder&, const Usage& u) {
  if (e.number("rate") == 0) return Share{};
  if (!u.duration || !u.velocity) return std::nullopt;
  const double latest = std::abs(e.number("rate")) * *u.duration;
  return Share{0, latest * u.velocity->largest(), latest * u.velocity->rms() / std::numbers::sqrt3,
               Spectrum::motion};
}

}  // namespace

EffectKind clock_drift_effect() {
  return {.name = "clock_drift",
          .summary = "the encoder's clock runs fast or slow against the reference's",
          .typical = "10 to 100 ppm between two crystals",
          .stage = Stage::clock,
          .parameters =
              {{.name = "rate", .meaning = "relative rate error", .required = true, .least = -1, .most = 1}},
          .action = [](const Effect& e, const Encoder&, std::uint64_t) -> Action {
            return [rate = e.number("rate")](double t, const Moment& m) { return t + rate * m.time; };
          },
          .share = share,
          .need = Need::duration,
          .terms = terms,
          .remedy = {false, "discipline one clock by the other"}};
}

}  // namespace qerr
