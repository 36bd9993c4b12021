#pragma once

#include <cmath>
#include <vector>

#include "qerr/effect/effect_kind.hpp"

namespace qerr {

/// Effects of stage `decoder` on the counts of one encoder, which are defined for integers.
struct Decoder {
  std::vector<Action> actions;
  double sign = 1;  ///< of the counter: its direction

  bool empty() const { return actions.empty(); }

  /// @param count  along the joint coordinate
  double operator()(double count, const Moment& m) const {
    double x = sign * count;
    for (const Action& action : actions) x = action(x, m);
    return sign * x;
  }

  /// Mean over the encoder's zero at a position in counts: interpolated between the two next integers.
  double mean(double position, const Moment& m) const {
    const double below = std::floor(position), part = position - below, decoded = (*this)(below, m);
    return part == 0 ? decoded : decoded + part * ((*this)(below + 1, m) - decoded);
  }
};

}  // namespace qerr
