#pragma once

#include <optional>
#include <string>
#include <vector>

#include "diagnose/inference/explanation.hpp"

namespace qerr {

inline constexpr double scatter_beyond_reference = 1.3;  ///< times what is left of the reference's noise
inline constexpr double scatter_worth_naming = 0.12;     ///< [counts]

/// What scatters the readings about a model's path more than the reference's own noise can.
struct Scatter {
  std::optional<Effect> effect;  ///< noise, timing_jitter or state_width; empty: none of them
  double p_value = 1;
  double relative_error = 0;          ///< half the 95 % interval of its parameter, as a part of it
  std::optional<Effect> alternative;  ///< fits as well
  /// The scatter is correlated from reading to reading, comes and goes, or is in some readings only: what it
  /// is that nothing explains; empty: no such thing.
  std::string structure;
  double size = 0;  ///< standard deviation beyond the reference's noise [rad or m]
};

/// Tries, when all mean effects are in the model: white noise before the quantizer, sigma^2 = s_r^2 + s_n^2;
/// jitter of the sampling, sigma^2 = s_r^2 + (v s_t)^2; unequal quadrature states, edges of odd number
/// displaced.
/// @param m  its terms are fitted; an offset among them is set against unequal states
Scatter scatter_of(const Evidence&, const Explanation& m);

}  // namespace qerr
