#pragma once

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

}  // namespace qerr
