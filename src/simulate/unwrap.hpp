#pragma once

#include <cstdint>

namespace qerr {

/// The whole turns to add after a step of a periodic quantity: -1 for a step of about +turn, +1 for one of
/// about -turn, else 0. "About" is nearer to it than a quarter of a turn.
int turns_after(double step, double turn);

/// Follows a position that is read within one turn and starts anew at its end: a tracker's angle, an absolute
/// encoder's count.
///
/// A sample is taken for a wrap when, seen from where the two before it lead (2 u[i-1] - u[i-2]), it is off
/// by a turn, less than a quarter of one more or less, and when all samples as read span one turn (and 1 % of
/// it for an uneven reading): a position that runs on beyond a turn does not wrap at one, and what jumps in
/// it is data (missed counts, a rollover at another power of two). Steps between a quarter and three quarters
/// of a turn away from the expected are data too. The rule holds while the velocity changes by less than a
/// quarter of a turn per sample.
class Unwrap {
 public:
  /// @param turn  what is added or taken away [unit of the values], > 0
  explicit Unwrap(double turn) : turn_(turn) {}

  /// The next sample, without its wraps: value + turns() * turn.
  double operator()(double value);

  /// Turns added so far.
  std::int64_t turns() const { return turns_; }

  /// Whether a wrap was taken out, and later samples as read span more than a turn: then it was no wrap.
  bool contradicted() const { return wrapped_ && beyond_; }

 private:
  double turn_;
  double lowest_ = 0, highest_ = 0;    // as read
  double last_ = 0, before_last_ = 0;  // unwrapped
  std::int64_t turns_ = 0;
  bool started_ = false, wrapped_ = false, beyond_ = false;
};

}  // namespace qerr
