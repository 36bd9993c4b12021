#include "effect/effects/effects.hpp"
#include "encoder/loop_reading.hpp"

namespace qerr {

namespace {

/// The ratio multiplies what the disc turns by: what clock, link and gear add, too.
Term along(const RecordSignals& s, const Term& t, const Eigen::ArrayXd& moved) {
  Term next = t;
  next.columns = s.path + moved;
  next.moved = moved;
  return next;
}

std::vector<Term> terms(const RecordSignals& s) {
  if (s.is_stationary()) return {};
  Term t =
      linear_term(s, "scale", s.path, [](Effect& e, const Eigen::VectorXd& c) { e.numbers["scale"] = c[0]; });
  t.along = along;
  return {t};
}

}  // namespace

EffectKind scale_effect() {
  return {
      .name = "scale",
      .summary = "error proportional to the angle: wrong gear ratio or counts per revolution",
      .typical = "1e-4 to 1: a belt's pitch, a ratio given in round numbers",
      .stage = Stage::disc,
      .parameters = {{.name = "scale",
                      .meaning = "relative error of the angle",
                      .required = true,
                      .least = -10,
                      .most = 10}},
      .action = [](const Effect& e, const Encoder&, std::uint64_t) -> Action {
        return [scale = e.number("scale")](double x, const Moment&) { return x + scale * x; };
      },
      .share = [](const Effect& e, const Encoder&,
                  const Usage& u) { return proportional(e.number("scale"), u.position); },
      .need = Need::position,
      .in_loop = [](const Effect& e, const Encoder&, LoopReading& r) { r.factor *= 1 + e.number("scale"); },
      .terms = terms,
      // The disc turns by the angle that the true ratio gives.
      .first_in_stage = true,
      .twins = {{"clock_drift",
                 "a return to the start late in the record: the scale error vanishes there, the clock's "
                 "does not"}},
      .record = "a wider range of the joint, several revolutions if possible",
      .table = TableShape{.linear = true},
      .remedy = {true, "correct the gear ratio or the counts per revolution, or use the look-up table"}};
}

}  // namespace qerr
