#include <algorithm>

#include "effect/effects/effects.hpp"

namespace qerr {

namespace {

/// The motor leads the joint by half the gap in the direction of the last motion; before the first motion it
/// is in the middle of the gap.
Action action(const Effect& e, const Encoder&, std::uint64_t) {
  return
      [half = 0.5 * e.number("gap"), side = 0.0, last = 0.0, first = true](double x, const Moment&) mutable {
        if (!first && x != last) side = x > last ? 1 : -1;
        first = false;
        last = x;
        return x + side * half;
      };
}

/// Play operator: displacement of the driving side from the link per unit of the gap. The link rests until a
/// flank touches it.
Eigen::ArrayXd play(const Eigen::ArrayXd& motor, double gap) {
  Eigen::ArrayXd added(motor.size());
  double link = motor[0];
  for (Eigen::Index k = 0; k < motor.size(); ++k) {
    link = std::clamp(link, motor[k] - 0.5 * gap, motor[k] + 0.5 * gap);
    added[k] = (motor[k] - link) / gap;
  }
  return added;
}

std::vector<Term> terms(const RecordSignals& s) {
  if (!s.ordered || s.is_stationary()) return {};
  Term t = linear_term(s, "backlash", 0.5 * s.direction,
                       [](Effect& e, const Eigen::VectorXd& c) { e.numbers["gap"] = c[0]; });
  t.positive = true;
  t.hysteresis = play;
  return {t};
}

}  // namespace

EffectKind backlash_effect() {
  return {.name = "backlash",
          .summary = "play between encoder and joint",
          .typical = "1 to 10 arcmin in gears, none in a harmonic drive",
          .stage = Stage::gear,
          .parameters = {{.name = "gap",
                          .meaning = "full width of the play",
                          .required = true,
                          .least = 0,
                          .coordinate = true}},
          .action = action,
          .share = [](const Effect& e, const Encoder&, const Usage&) -> std::optional<Share> {
            const double half = 0.5 * e.number("gap");
            return Share{0, half, half, Spectrum::motion};
          },
          .terms = terms,
          // The record's side of motion ignores reversals within the reference's noise; the action would not.
          .replay = [](const Effect& e, const RecordSignals& s) -> Eigen::ArrayXd {
            return 0.5 * e.number("gap") * s.direction;
          },
          // The gear's periodic errors depend on the angle after the play.
          .first_in_stage = true,
          .remedy = {true,
                     "add or subtract half the gap by the last direction of motion; not possible around "
                     "reversals"}};
}

}  // namespace qerr
