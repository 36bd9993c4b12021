#pragma once

#include <array>

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

/// The intervals of readings between displaced edges.
Intervals displaced(Intervals, const Evidence&, const EdgePattern&);

}  // namespace qerr
