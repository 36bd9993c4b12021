#pragma once

#include <cstddef>

#include "lanes/select_kernels.hpp"

namespace qerr {

// Included by kernel sources: without Eigen and containers.

/// A convex function of the tip, tabulated over cylindrical coordinates about a joint's axis, and a quadratic
/// form of the tip: F(y) = sqrt(table(y)^2 + y.Q y + 2 b.y + c).
struct TipTable {
  const double* values = nullptr;  ///< [z][r][azimuth, one more than nodes; or 1]; null: 0
  std::size_t radii = 0, heights = 0, columns = 1;
  double radii_per_length = 0, lowest = 0, heights_per_length = 0;
  const double *node_cos = nullptr, *node_sin = nullptr;  ///< [columns]
  const int* node_of_bin = nullptr;
  std::size_t bins = 0;
  double q[6] = {};  ///< xx yy zz xy xz yz
  double b[3] = {}, c = 0;
};

/// Kernels compiled once per instruction set.
struct TipKernels {
  /// Values of F at `count` points, from above up to rounding. The table is interpolated along the chord
  /// between azimuths (y = r' (weights of the unit vectors at both nodes), r' >= the radius of y) and in r'
  /// and z: weighted averages of values whose weighted average of points is y, Jensen's inequality.
  void (*evaluate)(const TipTable&, const double* x, const double* y, const double* z, double* values,
                   std::size_t count);
};

}  // namespace qerr
