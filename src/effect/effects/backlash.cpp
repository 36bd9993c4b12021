#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "core/solve.hpp"
#include "core/statistics.hpp"
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

constexpr double stops_at_once = std::numeric_limits<double>::infinity();

/// Deceleration of a joint that no flank touches, by its own friction [rad/s^2 or m/s^2].
double deceleration(const Effect& e) { return e.number_or("deceleration", stops_at_once); }

/// A joint that its drive moves through the play, and that coasts from the speed at which a flank has left
/// it.
struct Coasting {
  double gap, deceleration;
  double at = 0, speed = 0;

  /// @param touched_speed  of the joint while a flank touches it, as of its drive
  void move(double driving, double duration, double touched_speed) {
    double coasted = at;
    if (std::isfinite(deceleration)) {
      const double slower = std::max(0.0, std::abs(speed) - deceleration * duration),
                   moving = std::min(duration, std::abs(speed) / deceleration);
      coasted += std::copysign(0.5 * (std::abs(speed) + slower) * moving, speed);
      speed = std::copysign(slower, speed);
    }
    at = driven(coasted, driving, gap);
    if (at != coasted) speed = touched_speed;
  }
};

/// The flank that the drive pushes, as a joint moves: ahead of it, unless it slows down by more than its
/// friction does. 0 at rest.
double flank(double velocity, double acceleration, double deceleration) {
  const double ahead = velocity > 0 ? 1 : velocity < 0 ? -1 : 0;
  return ahead * acceleration < -deceleration ? -ahead : ahead;
}

/// An encoder on the drive's side leads the joint by half the gap in the direction of the last motion, or
/// on the flank that a coasting joint needs; before the first motion it is in the middle of the gap. Where
/// jitter exchanges the instants of two readings, the joint has not turned round. One on the load's side is
/// driven through the play.
Action action(const Effect& e, const Encoder&, std::uint64_t) {
  if (lags(e))
    return [joint = Coasting{e.number("gap"), deceleration(e)}, last = 0.0, instant = 0.0, first = true](
               double x, const Moment& m) mutable {
      const double duration = m.time - instant;
      if (first) joint.at = x;
      if (!first && duration > 0) joint.move(x, duration, (x - last) / duration);
      first = false, last = x, instant = m.time;
      return joint.at;
    };
  return [half = 0.5 * e.number("gap"), slowed = deceleration(e), side = 0.0, last = 0.0, velocity = 0.0,
          instant = 0.0, rows = 0](double x, const Moment& m) mutable {
    if (const double duration = m.time - instant; rows++ > 0 && x != last && duration != 0) {
      const double before = std::exchange(velocity, (x - last) / duration);
      side = flank(velocity, rows > 2 ? (velocity - before) / duration : 0, slowed);
    }
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

/// The drive's side of a joint that coasts, as the joint's own motion tells it: at rest the last one.
Eigen::ArrayXd flanks(const RecordSignals& s, double deceleration) {
  if (!std::isfinite(deceleration) || s.acceleration.size() == 0) return s.direction;
  constexpr double moving = 0.02;  // of the largest speed, as of stops (convention)
  const double slowest = moving * s.joint_rate().abs().maxCoeff();
  Eigen::ArrayXd side = s.direction;
  for (Eigen::Index k = 1; k < side.size(); ++k)
    side[k] = std::abs(s.joint_rate()[k]) < slowest ? side[k - 1]
                                                    : flank(s.direction[k], s.acceleration[k], deceleration);
  return side;
}

/// Displacement of the driving side from a joint that coasts, row by row.
/// @param first  of the joint from the middle of the play, before the first row
Eigen::ArrayXd lead_of_coasting(const RecordSignals& s, const Eigen::ArrayXd& driving, double first,
                                double gap, double deceleration) {
  Eigen::ArrayXd ahead(driving.size());
  Coasting joint{gap, deceleration, driven(driving[0] + first, driving[0], gap), s.joint_rate()[0]};
  for (Eigen::Index k = 0; k < driving.size(); ++k) {
    joint.move(driving[k], k > 0 ? s.time[k] - s.time[k - 1] : 0, s.joint_rate()[k]);
    ahead[k] = driving[k] - joint.at;
  }
  return ahead;
}

/// The error of the first row from the middle between the extremes.
double first_error(const RecordSignals& s) {
  const Eigen::ArrayXd error = s.measured - s.path;
  return error[0] - 0.5 * (error.minCoeff() + error.maxCoeff());
}

/// Displacement of an encoder on the drive's side from the joint, per unit of the gap. While the drive
/// crosses the play, only the readings tell where it is.
Eigen::ArrayXd lead(const RecordSignals& s, double gap, double deceleration) {
  if (!s.readings_drive(gap)) return 0.5 * flanks(s, deceleration);
  const Eigen::ArrayXd driving = s.drive(gap);
  if (!std::isfinite(deceleration)) return lead(driving, gap);
  // Within a count of a flank it is at the flank: what the readings round is no motion in the play.
  return lead_of_coasting(s, driving, -first_error(s), gap, deceleration).unaryExpr([&](double ahead) {
    return 0.5 * gap - std::abs(ahead) < s.step() ? std::copysign(0.5, ahead) : ahead / gap;
  });
}

/// Displacement of an encoder on the load's side from what drives it, per unit of the gap.
Eigen::ArrayXd lag(const RecordSignals& s, double gap, double deceleration) {
  if (!std::isfinite(deceleration)) return lag(s.joint_angle(), gap);
  return -lead_of_coasting(s, s.joint_angle(), first_error(s), gap, deceleration) / gap;
}

/// Some rows of a record, in which the deceleration of a joint is seen that coasts through its play. The gap
/// is found beside it, as far as a scale and an eccentricity leave it.
class CoastingScan {
 public:
  using Column = Eigen::ArrayXd (*)(const RecordSignals&, double gap, double deceleration);

  CoastingScan(const RecordSignals& s, Column column) : column_(column) {
    constexpr Eigen::Index most = 1 << 14;
    const auto some = Eigen::seq(0, Eigen::last, (s.rows() + most - 1) / most);
    some_.encoder = s.encoder;
    some_.time = s.time(some), some_.path = s.path(some), some_.measured = s.measured(some);
    some_.velocity = s.velocity(some), some_.acceleration = s.acceleration(some);
    some_.direction = s.direction(some);
    const Eigen::ArrayXd &path = some_.path, shaft = s.encoder.shaft_ratio * path;
    Eigen::MatrixXd beside(path.size(), 4);
    beside << Eigen::VectorXd::Ones(path.size()), path, shaft.sin(), shaft.cos();
    beside_ = orthonormal_basis(beside);
    error_ = apart(some_.measured - path);
    typical_ = rms(error_);
  }

  struct Fit {
    double gap = 0, left = 0;  ///< rms of what is left [rad or m]
  };
  /// The fit from the gap of a play whose flanks are touched equally long.
  Fit at(double deceleration) const {
    constexpr int steps = 3;
    return at(deceleration, 2 * typical_, steps);
  }
  Fit at(double deceleration, double about, int steps) const {
    Fit fit{about, typical_};
    for (int i = 0; i < steps; ++i) {
      const Eigen::VectorXd column = apart(column_(some_, fit.gap, deceleration));
      const double own = column.squaredNorm(), gap = column.dot(error_) / own;
      if (!(gap > 0)) return {fit.gap, typical_};
      fit = {gap, std::sqrt(std::max(0.0, error_.squaredNorm() - gap * gap * own) /
                            static_cast<double>(error_.size()))};
    }
    return fit;
  }

  /// The deceleration that leaves least, from one that takes the whole record to that of one row. None where
  /// more is left than of a play, or hardly less than of one whose joint stops at once.
  std::optional<double> best() const {
    constexpr double part_left = 0.3, counts_left = 0.6, less = 0.8, rounding = 0.4;  // conventions
    // A coarse step of the deceleration may miss half of what the best one explains.
    constexpr double coarse = 2, fine = 1.01, promising = 0.7;
    if (typical_ < rounding * some_.step()) return std::nullopt;
    const Eigen::Index last = some_.time.size() - 1;
    const double rate = std::sqrt(some_.velocity.square().mean()),
                 duration = some_.time[last] - some_.time[0];
    double best = 0;
    Fit least{2 * typical_, std::numeric_limits<double>::infinity()};
    const auto attempt = [&](double deceleration) {
      constexpr int steps = 2;
      if (const Fit fit = at(deceleration, least.gap, steps); fit.left < least.left)
        least = fit, best = deceleration;
    };
    for (double d = rate / duration; d * duration < rate * static_cast<double>(last); d *= coarse) attempt(d);
    if (!(least.left < promising * typical_)) return std::nullopt;
    for (double ratio = std::sqrt(coarse); ratio > fine; ratio = std::sqrt(ratio)) {
      const double middle = best;
      attempt(middle / ratio), attempt(middle * ratio);
    }
    const bool is_play = least.left < std::max(part_left * typical_, counts_left * some_.step()) &&
                         least.left < less * at(stops_at_once).left;
    // A joint that lags may also be late; none leads by being early.
    const auto beyond_rounding = [&](double left) {
      return std::sqrt(std::max(0.0, left * left - some_.step() * some_.step() / 12));
    };
    const bool is_late = column_ == static_cast<Column>(lag) &&
                         beyond_rounding(least.left) >= part_left * beyond_rounding(left_by_latency());
    return is_play && !is_late ? std::optional(best) : std::nullopt;
  }

 private:
  /// What a latency leaves: of several rows its path is shifted, as corners have no rate.
  double left_by_latency() const {
    constexpr int steps = 3;
    const Eigen::VectorXd rate = apart(some_.velocity);
    Eigen::VectorXd left = error_;
    double ahead = 0;
    for (int step = 0; step < steps; ++step) {
      ahead += rate.dot(left) / rate.squaredNorm();
      Eigen::Index next = 1;
      const Eigen::ArrayXd shifted = some_.time.unaryExpr([&](double time) {
        while (next + 1 < some_.time.size() && some_.time[next] < time + ahead) ++next;
        const double part = (time + ahead - some_.time[next - 1]) / (some_.time[next] - some_.time[next - 1]);
        return some_.path[next - 1] + part * (some_.path[next] - some_.path[next - 1]);
      });
      left = apart(some_.measured - shifted);
    }
    return rms(left);
  }

  Eigen::VectorXd apart(const Eigen::ArrayXd& column) const {
    return column.matrix() - beside_ * (beside_.transpose() * column.matrix());
  }

  Column column_;
  RecordSignals some_;
  Eigen::VectorXd error_;
  Eigen::MatrixXd beside_;  // orthonormal: a constant, a scale, an eccentricity
  double typical_ = 0;
};

template <CoastingScan::Column column>
std::vector<double> decelerations(const RecordSignals& s) {
  const auto best = CoastingScan(s, column).best();
  return best ? std::vector{*best} : std::vector<double>{};
}

/// A play whose joint coasts with this deceleration.
/// @param plain  the same of a joint that stops at once
template <CoastingScan::Column column>
Term coasting(const RecordSignals& s, const Term& plain, double deceleration) {
  Term t = plain;
  t.columns = Eigen::ArrayXd::Zero(s.rows());
  if (std::isfinite(deceleration))
    t.columns = column(s, CoastingScan(s, column).at(deceleration).gap, deceleration);
  t.effect.numbers["deceleration"] = t.shape = deceleration;
  t.reshaped = coasting<column>;
  t.shapes = decelerations<column>;
  return t;
}

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
  if (s.coupled() || s.measured.size() == 0 || s.acceleration.size() == 0) return {drive, load};
  return {coasting<lead>(s, drive, stops_at_once), coasting<lag>(s, load, stops_at_once), drive, load};
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
                     {.name = "deceleration",
                      .dimension = dimension::angular_acceleration,
                      .meaning =
                          "of the joint by its own friction while no flank touches it: it coasts; without "
                          "this it stops at once. A simulation does not know the drive, which crosses the "
                          "play at once",
                      .least = 0,
                      .open_below = true},
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
      .replay = [](const Effect& e, const RecordSignals& s) -> Eigen::ArrayXd {
        if (lags(e)) return {};
        return e.number("gap") * lead(s, e.number("gap"), deceleration(e));
      },
      // The gear's periodic errors depend on the angle after the play.
      .first_in_stage = true,
      .remedy = {true,
                 "add or subtract half the gap by the last direction of motion; not possible around "
                 "reversals"}};
}

}  // namespace qerr
