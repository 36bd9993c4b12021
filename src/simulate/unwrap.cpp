#include "simulate/unwrap.hpp"

#include <complex>
#include <numbers>

#include "core/statistics.hpp"

namespace qerr {

Eigen::ArrayXd turns_by_difference(const Eigen::ArrayXd& difference, const std::vector<Eigen::Index>& rows,
                                   double turn) {
  // The mean direction of the differences as angles of a turn.
  std::complex<double> sum = 0;
  for (const double d : difference) sum += std::polar(1.0, 2 * std::numbers::pi * d / turn);
  double last = std::arg(sum) / (2 * std::numbers::pi) * turn;
  Eigen::ArrayXd turns(difference.size());
  for (const Eigen::Index row : rows) {
    turns[row] = -std::round((difference[row] - last) / turn);
    const double now = difference[row] + turns[row] * turn;
    if (std::abs(now - last) < 0.25 * std::abs(turn)) last = now;
  }
  const Eigen::ArrayXd without = difference + turns * turn;
  return turns - std::round(median({without.begin(), without.end()}) / turn);
}

int turns_after(double step, double turn) {
  if (std::abs(step - turn) < 0.25 * turn) return -1;
  return std::abs(step + turn) < 0.25 * turn ? 1 : 0;
}

/// The next state, a number of samples later.
Unwrap::State Unwrap::after(const State& s, double value, double samples) const {
  State next = s;
  next.lowest = std::min(s.lowest, value);
  next.highest = std::max(s.highest, value);
  const double unwrapped = value + static_cast<double>(s.turns) * turn_;
  if (!is_beyond(next)) next.turns += turns_after(unwrapped - (s.last + samples * s.velocity), turn_);
  next.wrapped = s.wrapped || next.turns != s.turns;
  next.last = value + static_cast<double>(next.turns) * turn_;
  next.velocity = (next.last - s.last) / samples;
  return next;
}

double Unwrap::judged(double value) {
  withdrawn_ = 0;
  if (!started_) {
    started_ = true;
    now_ = {value, value, value};
    return value;
  }
  const auto deviation = [](const State& from, const State& to, double samples) {
    return std::abs(to.last - (from.last + samples * from.velocity));
  };
  State next = after(now_, value, 1);
  const double off = deviation(now_, next, 1);
  const bool jumped = far_off_;
  // Only a sample whose prediction does not itself come from a jump is judged.
  far_off_ = !jumped && off > noticeable * turn_;
  if (jumped) {
    State without = after(before_, value, 2);
    const bool other_turns = without.turns != next.turns;
    if (deviation(before_, without, 2) < noticeable * turn_ && (other_turns || off > noticeable * turn_)) {
      withdrawn_ = now_.turns - before_.turns;
      // Within a quarter turn it may be motion: then only the span of the samples is corrected.
      if (!other_turns && off <= 0.25 * turn_) without.velocity = next.velocity;
      next = now_ = without;
    }
  }
  if (far_off_) before_ = now_;
  now_ = next;
  return now_.last;
}

}  // namespace qerr
