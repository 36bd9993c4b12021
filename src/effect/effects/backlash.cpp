#include <algorithm>

#include "effect/effects/effects.hpp"
#include "encoder/loop_reading.hpp"

namespace qerr {

namespace {

/// Whether the encoder is behind the play, so that it lags what moves it.
bool lags(const Effect& e) {
  const auto side = e.choices.find("side");
  return side != e.choices.end() && side->second == "load";
}

/// Position of what is driven through the play: it rests until a flank touches it.
double driven(double before, double driving, double gap) {
  return std::clamp(before, driving - 0.5 * gap, driving + 0.5 * gap);
}

/// An encoder on the drive's side leads the joint by half the gap in the direction of the last motion; before
/// the first motion it is in the middle of the gap. Where jitter exchanges the instants of two readings, the
/// joint has not turned round. One on the load's side is driven through the play.
Action action(const Effect& e, const Encoder&, std::uint64_t) {
  if (lags(e))
    return [gap = e.number("gap"), at = 0.0, first = true](double x, const Moment&) mutable {
      at = first ? x : driven(at, x, gap);
      first = false;
      return at;
    };
  return [half = 0.5 * e.number("gap"), side = 0.0, last = 0.0, instant = 0.0, first = true](
             double x, const Moment& m) mutable {
    if (!first && x != last && m.time != instant) side = (x > last) == (m.time > instant) ? 1 : -1;
    first = false;
    last = x;
    instant = m.time;
    return x + side * half;
  };
}

/// Displacement of the driving side from the driven one per unit of the gap.
Eigen::ArrayXd lead(const Eigen::ArrayXd& driving, double gap) {
  Eigen::ArrayXd added(driving.size());
  double at = driving[0];
  for (Eigen::Index k = 0; k < driving.size(); ++k) {
    at = driven(at, driving[k], gap);
    added[k] = (driving[k] - at) / gap;
  }
  return added;
}

Eigen::ArrayXd lag(const Eigen::ArrayXd& driving, double gap) { return -lead(driving, gap); }

std::vector<Term> terms(const RecordSignals& s) {
  if (!s.ordered || s.is_stationary()) return {};
  Term drive = linear_term(s, "backlash", 0.5 * s.direction,
                           [](Effect& e, const Eigen::VectorXd& c) { e.numbers["gap"] = c[0]; });
  drive.positive = 1;
  drive.hysteresis = lead;
  Term load = drive;
  load.columns *= -1;
  load.effect.choices["side"] = "load";
  load.hysteresis = lag;
  load.of_reference = true;
  return {drive, load};
}

}  // namespace

EffectKind backlash_effect() {
  return {
      .name = "backlash",
      .summary = "play between encoder and joint",
      .typical = "1 to 10 arcmin in gears, none in a harmonic drive",
      .stage = Stage::gear,
      .parameters = {{.name = "gap",
                      .meaning = "full width of the play",
                      .required = true,
                      .least = 0,
                      .most = 10,  // above a revolution, or of a machine tool's size in m
                      .coordinate = true},
                     {.name = "side",
                      .kind = Kind::choice,
                      .meaning = "side of the play on which the encoder is",
                      .choices = "drive|load"}},
      .action = action,
      .share = [](const Effect& e, const Encoder&, const Usage&) -> std::optional<Share> {
        const double half = 0.5 * e.number("gap");
        return Share{0, half, half, Spectrum::motion, e.number("gap")};
      },
      .in_loop =
          [](const Effect& e, const Encoder&, LoopReading& r) {
            r.play += e.number("gap");
            r.behind_play = lags(e);
          },
      .terms = terms,
      // The record's side of motion ignores reversals within the reference's noise; the action would not.
      // While the drive crosses the play the joint stands still: only the readings tell where the drive is.
      .replay = [](const Effect& e, const RecordSignals& s) -> Eigen::ArrayXd {
        const double gap = e.number("gap");
        if (lags(e)) return {};
        if (s.readings_drive(gap)) return gap * lead(s.drive(), gap);
        return 0.5 * gap * s.direction;
      },
      // The gear's periodic errors depend on the angle after the play.
      .first_in_stage = true,
      .remedy = {true,
                 "add or subtract half the gap by the last direction of motion; not possible around "
                 "reversals"}};
}

}  // namespace qerr
