#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "diagnose/inference/explanation.hpp"

namespace qerr {

/// Positions of the edges of an encoder whose states repeat every four counts.
struct EdgePattern {
  /// Displacement of the edges with number 0 .. 3 mod 4 from their common mean [counts]. Edge k lies between
  /// the counts k - 1 and k.
  std::array<double, 4> displacement{};
  double alternating = 0;        ///< displacement of odd edges from even ones [counts]
  double alternating_error = 0;  ///< its standard error
  double p_value = 1;            ///< of edges without a pattern: Hotelling's T^2 over blocks of the record

  double largest() const;
};

/// Estimates the pattern from the readings about a model's path.
///
/// Of the readings for which edge k is the nearest, those beyond it show the count k and the others k - 1. A
/// displaced edge changes the reading of positions between its place and the ideal one: their number, in the
/// units of all readings near the edge, is the displacement, at any speed and with any symmetric noise.
/// @returns no pattern if the readings are no counts, or if there are too few
EdgePattern edge_pattern(const Evidence&, const Explanation&);

/// A model's intervals, of readings between displaced edges.
Intervals displaced(const Evidence&, const Explanation&, const EdgePattern&);

inline constexpr double scatter_beyond_reference = 1.3;  ///< times the noise that remains in the path
inline constexpr double scatter_worth_naming = 0.12;     ///< [counts]

/// Correlation of neighbouring residuals from which they are a signal, not noise: 5 standard errors of a
/// white sequence of 625 rows.
inline constexpr double correlated_residual = 0.2;

/// An effect that scatters the readings about an unchanged mean path.
struct ScatterCause {
  Effect effect;
  double p_value = 1;
  double relative_error = 0;          ///< half the 95 % interval of its parameter, as a part of it
  double rms = 0;                     ///< of what it adds [rad or m]
  std::optional<Effect> alternative;  ///< fits as well
};

/// Scatter of the readings about a model's path beyond the noise of the reference.
struct Scatter {
  std::vector<ScatterCause> causes;
  double size = 0;  ///< standard deviation beyond the reference's noise [rad or m]
  /// Variance of every reading about the path that reference, quantization and the causes make
  /// [rad^2 or m^2].
  Eigen::ArrayXd expected;
  EdgePattern pattern;
};

/// Fits, with all mean effects in the model, the edges of a quadrature encoder and the random effects of the
/// catalogue, sigma^2 = s_r^2 + sum of (size * deviation)^2 row by row (uniform for noise, the velocity for
/// jitter): one after the other, as long as the likelihood rises significantly.
/// A residual that is correlated from reading to reading, that is uneven along the path or in time, or that
/// is smaller than what uncatalogued terms explain, is no random effect.
/// @param m        fitted
/// @param unnamed  size of the largest uncatalogued term [rad or m]
Scatter scatter_of(const Evidence&, const Explanation& m, double unnamed);

}  // namespace qerr
