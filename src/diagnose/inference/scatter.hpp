#pragma once

#include <optional>
#include <string>
#include <vector>

#include "diagnose/inference/explanation.hpp"

namespace qerr {

inline constexpr double scatter_beyond_reference = 1.3;  ///< times the noise that remains in the path
inline constexpr double scatter_worth_naming = 0.12;     ///< [counts]

/// Scatter of the readings about a model's path beyond the noise of the reference.
struct Scatter {
  std::optional<Effect> effect;  ///< of the catalogue's effects with a `scattering`; empty: none
  double p_value = 1;
  double relative_error = 0;          ///< half the 95 % interval of its parameter, as a part of it
  std::optional<Effect> alternative;  ///< fits as well
  /// Description of an unexplained structure: correlation from reading to reading, uneven scatter, or
  /// outliers; empty: none.
  std::string structure;
  Shape shape = Shape::unknown;  ///< of the structure
  double size = 0;  ///< standard deviation beyond the reference's noise [rad or m]
};

/// Fits, with all mean effects in the model, every random effect of the catalogue,
/// sigma^2 = s_r^2 + (size * deviation)^2 row by row (uniform for noise, the velocity for jitter), and those
/// that displace edges of odd number.
/// @param m  fitted; a constant term among them is replaced by the mean of displaced edges
Scatter scatter_of(const Evidence&, const Explanation& m);

}  // namespace qerr
