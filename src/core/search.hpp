#pragma once

#include <algorithm>
#include <numbers>

namespace qerr {

/// An interval at whose ends a condition differs.
struct Change {
  double holds, fails;  ///< where the condition holds, and where it does not; either may be the smaller one

  double middle() const { return 0.5 * (holds + fails); }
};

/// Halves an interval `steps` times around a change of the condition, which holds at `at.holds` and not at
/// `at.fails`.
template <class Condition>
Change bisect(Change at, int steps, const Condition& condition) {
  for (int i = 0; i < steps; ++i) {
    const double middle = at.middle();
    (condition(middle) ? at.holds : at.fails) = middle;
  }
  return at;
}

/// The maximum of a function in a small interval.
struct Peak {
  double low, high;  ///< ends of the interval
  double value;      ///< largest one found: accurate to the square of the interval's width

  double middle() const { return 0.5 * (low + high); }
};

/// Narrows the interval around the only maximum of a function by 0.618 per step, with one evaluation each
/// (golden sections).
template <class Function>
Peak golden_section(double low, double high, int steps, const Function& f) {
  constexpr double ratio = 1 / std::numbers::phi;
  double left = high - ratio * (high - low), right = low + ratio * (high - low);
  double at_left = f(left), at_right = f(right);
  for (int i = 0; i < steps; ++i) {
    if (at_left > at_right) {
      high = right, right = left, at_right = at_left;
      left = high - ratio * (high - low), at_left = f(left);
    } else {
      low = left, left = right, at_left = at_right;
      right = low + ratio * (high - low), at_right = f(right);
    }
  }
  return {low, high, std::max(at_left, at_right)};
}

}  // namespace qerr
