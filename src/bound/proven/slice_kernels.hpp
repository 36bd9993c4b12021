#pragma once

#include "lanes/select_kernels.hpp"

namespace qerr {

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

}  // namespace qerr
