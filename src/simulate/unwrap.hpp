#pragma once

#include <cstdint>

namespace qerr {

/// Turns to add after a step of a periodic quantity: -1 if the step is within a quarter turn of +turn, +1 if
/// it is within a quarter turn of -turn, else 0.
int turns_after(double step, double turn);

/// Unwraps a position that is measured modulo one turn: the angle of a tracker, the count of an absolute
/// encoder.
///
/// A sample is a wrap if it differs from the linear prediction 2 u[i-1] - u[i-2] by one turn within a quarter
/// turn, and if all samples so far span at most one turn (plus 1 % for measurement errors): a position that
/// exceeds the span of a turn does not wrap at a turn, and its jumps are data (missed counts, a rollover at
/// another power of two). So are deviations between a quarter and three quarters of a turn. The rule is valid
/// while the velocity changes by less than a quarter turn per sample.
class Unwrap {
 public:
  /// @param turn  interval of the wraps [unit of the values], > 0
  explicit Unwrap(double turn) : turn_(turn) {}

  /// The next sample, unwrapped: value + turns() * turn.
  double operator()(double value);

  /// Turns added so far.
  std::int64_t turns() const { return turns_; }

  /// Whether a wrap was removed and later samples span more than a turn, so that it was not a wrap.
  bool contradicted() const { return wrapped_ && beyond_; }

 private:
  double turn_;
  double lowest_ = 0, highest_ = 0;    // of the samples
  double last_ = 0, before_last_ = 0;  // unwrapped
  std::int64_t turns_ = 0;
  bool started_ = false, wrapped_ = false, beyond_ = false;
};

}  // namespace qerr
