#pragma once

#include <vector>

#include "qerr/effect/effect_kind.hpp"

namespace qerr {

/// Effects of stage `decoder` on the counts of one encoder, which are defined for integers.
struct Decoder {
  std::vector<Action> actions;
  double sign = 1;   ///< of the counter: its direction
  double noise = 0;  ///< standard deviation of the position before the rounding [counts]

  bool empty() const { return actions.empty(); }

  /// @param count  along the joint coordinate
  double operator()(double count, const Moment& m) const {
    double x = sign * count;
    for (const Action& action : actions) x = action(x, m);
    return sign * x;
  }

  /// Mean over the encoder's zero and the noise at a position in counts.
  double mean(double position, const Moment&) const;

 private:
  /// Mean over the zero: interpolated between the two next integers.
  double mean_over_zero(double position, const Moment&) const;
};

/// 64 equally probable values of a standard normal number, scaled to the variance 1.
const std::vector<double>& normal_values();

}  // namespace qerr
