#pragma once

#include <cstddef>

#include "lanes/select_kernels.hpp"

namespace qerr {

// Included by kernel sources: without Eigen and containers.

/// Weighted sum of tables of functions of (m, s), s >= 0, that are homogeneous of degree 1 and convex. A
/// table holds values at (a M, b M, 1 - max(|a|, |b|)) for a, b in [-1, 1] at equal steps (both directions
/// from the node of m = 0), so that the nodes are on a pyramid; between them it is linear over triangles that
/// the diagonals do not cut, an interpolation from above.
///
/// At the node (a, b, s) of the values, with s its height and all coefficients in units of the table's M:
///   value_a a + value_b b + value_s s + sum_j weight_j table_j(row_a a + row_b b + row_s s, column..., root
///   s).
struct ConeSum {
  int count = 0;
  const float* table[3] = {};  ///< [nodes][nodes]
  int nodes = 0;               ///< odd; of the tables and of the values
  float weight[3] = {};
  float row_a[3] = {}, row_b[3] = {}, row_s[3] = {};
  float column_a[3] = {}, column_b[3] = {}, column_s[3] = {};
  float root = 0;  ///< factor of s in the tables
  float value_a = 0, value_b = 0, value_s = 0;
};

/// Kernels compiled once per instruction set.
struct ConeKernels {
  /// Raises rows first .. last - 1 of values ([nodes][nodes]) to the sum where that is larger.
  void (*raise)(const ConeSum&, int first, int last, float* values);
};

// Included by kernel sources: without Eigen and containers.

/// Weighted sum of tables at affine functions of the nodes of another: at node (a, b)
///   value_0 + value_a a + value_b b + sum_j weight_j table_j(row, column),
///   row = row_0 + row_a a + row_b b, column likewise,
/// tables interpolated bilinearly (from above where they are convex).
struct SliceSum {
  int count = 0;               ///< of tables
  const float* table[3] = {};  ///< [nodes][nodes]
  int table_nodes = 0;
  float weight[3] = {};
  float row_0[3] = {}, row_a[3] = {}, row_b[3] = {};
  float column_0[3] = {}, column_a[3] = {}, column_b[3] = {};
  float value_0 = 0, value_a = 0, value_b = 0;
};

/// Nodes of a square that lie in a disc: columns begin[a] .. end[a] - 1 of row a.
struct SliceNodes {
  int nodes = 0;
  const int *begin = nullptr, *end = nullptr;
};

/// Kernels compiled once per instruction set.
struct SliceKernels {
  /// Raises values ([nodes][nodes]) to the sum where that is larger.
  void (*raise)(const SliceSum&, const SliceNodes&, float* values);
};

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
