#include "simulate/unwrap.hpp"

#include <algorithm>
#include <cmath>

namespace qerr {

int turns_after(double step, double turn) {
  if (std::abs(step - turn) < 0.25 * turn) return -1;
  return std::abs(step + turn) < 0.25 * turn ? 1 : 0;
}

double Unwrap::operator()(double value) {
  if (!started_) {
    started_ = true;
    lowest_ = highest_ = last_ = before_last_ = value;
    return value;
  }
  lowest_ = std::min(lowest_, value);
  highest_ = std::max(highest_, value);
  beyond_ = highest_ - lowest_ > 1.01 * turn_;
  const double unwrapped = value + static_cast<double>(turns_) * turn_;
  if (!beyond_) {
    const int turns = turns_after(unwrapped - (2 * last_ - before_last_), turn_);
    turns_ += turns;
    wrapped_ = wrapped_ || turns != 0;
  }
  before_last_ = last_;
  last_ = value + static_cast<double>(turns_) * turn_;
  return last_;
}

}  // namespace qerr
