#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace qerr {

/// Turns to add after a step of a periodic quantity: -1 if the step is within a quarter turn of +turn, +1 if
/// it is within a quarter turn of -turn, else 0.
int turns_after(double step, double turn);

/// Turns to add to positions that are known modulo a turn, by their difference from other readings of the
/// same positions: along the rows it changes by less than a quarter turn, however far the positions are
/// apart. A row whose difference changes by more has no say in those of the next.
/// @param difference  of the positions and the others
/// @param rows  in which errors are alike from one to the next: in time, or by position
/// @returns such that the median difference is within half a turn
Eigen::ArrayXd turns_by_difference(const Eigen::ArrayXd& difference, const std::vector<Eigen::Index>& rows,
                                   double turn);

/// Unwraps a position that is measured modulo one turn: the angle of a tracker, the count of an absolute
/// encoder.
///
/// A sample is a wrap if it differs from the linear prediction u[i-1] + v by one turn within a quarter turn,
/// and if all samples so far span at most one turn: a position that exceeds the span of a turn does not wrap
/// at a turn, and its jumps are data (missed counts, a rollover at another power of two). So are deviations
/// between a quarter and three quarters of a turn. The rule is valid while the velocity changes by less than
/// a quarter turn per sample.
///
/// A single reading far off is no motion: where the next sample is as predicted from the samples before it,
/// the reading and its turn are disregarded (one that is off by nearly a turn is a wrap). The velocity to it
/// would remove further turns, without end.
class Unwrap {
 public:
  /// @param turn  interval of the wraps [unit of the values], > 0
  /// @param most_span  of the samples of a position that wraps [unit of the values]
  Unwrap(double turn, double most_span) : turn_(turn), most_span_(most_span) {}

  /// The counter of N counts a turn: it has N values.
  static Unwrap of_counter(double counts) { return {counts, counts - 0.5}; }

  /// A measured angle: 1 % of the turn for its errors.
  static Unwrap of_angle(double turn) { return {turn, 1.01 * turn}; }

  /// The next sample, unwrapped: value + turns() * turn.
  double operator()(double value) {
    const double unwrapped = value + static_cast<double>(now_.turns) * turn_;
    if (!started_ || far_off_ || !(std::abs(unwrapped - (now_.last + now_.velocity)) <= noticeable * turn_))
      return judged(value);
    // As predicted, which nearly all samples are: the same state without a copy.
    withdrawn_ = 0;
    now_.lowest = std::min(now_.lowest, value);
    now_.highest = std::max(now_.highest, value);
    now_.velocity = unwrapped - now_.last;
    return now_.last = unwrapped;
  }

  double turn() const { return turn_; }

  /// Turns added so far.
  std::int64_t turns() const { return now_.turns; }

  /// Turns of the sample before the last one that are withdrawn, because it was a single reading far off.
  std::int64_t withdrawn() const { return withdrawn_; }

  /// Whether a wrap was removed and later samples span more than a turn, so that it was not a wrap.
  bool contradicted() const { return now_.wrapped && is_beyond(now_); }

 private:
  /// Of a turn: a reading that is off by more is neither noise nor, for once, motion.
  static constexpr double noticeable = 1.0 / 16;

  /// The first sample, or one that is not as predicted.
  double judged(double value);

  /// What is known after a sample.
  struct State {
    double lowest = 0, highest = 0;  // of the samples
    double last = 0, velocity = 0;   // of the unwrapped ones; per sample
    std::int64_t turns = 0;
    bool wrapped = false;
  };
  State after(const State&, double value, double samples) const;
  bool is_beyond(const State& s) const { return s.highest - s.lowest > most_span_; }

  double turn_, most_span_;
  State before_, now_;  // before_: before a sample that is far off
  std::int64_t withdrawn_ = 0;
  bool started_ = false, far_off_ = false;
};

}  // namespace qerr
