#pragma once

#include <optional>
#include <string>

#include "diagnose/inference/scatter.hpp"
#include "qerr/effect/effect.hpp"

namespace qerr {

/// Ratio of a residual's rms to the expected one beyond which something is left to explain.
inline constexpr double remainder_worth_reporting = 1.3;

/// What a model and its scatter leave in the readings.
struct Remainder {
  double ratio = 1;  ///< rms of the residual over that of quantization, noise and the causes found
  double size = 0;   ///< rms of the residual beyond it [rad or m]
  std::string what;  ///< description; empty: nothing worth reporting is left
  Shape shape = Shape::unknown;
};

/// @param unnamed  size of what uncatalogued terms of the model explain: smaller remainders are their misfit
///   [rad or m]
Remainder remainder_of(const Evidence&, const Explanation&, const Scatter&, double unnamed);

}  // namespace qerr
