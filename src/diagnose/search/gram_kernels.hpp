#pragma once

#include <cstddef>

#include "lanes/select_kernels.hpp"

// Interface of the kernel of a Gram matrix. Files that are compiled per instruction set include this, and
// nothing that contains code of its own.

namespace qerr {

/// In Eigen's code, which is compiled for the baseline of the architecture, these products were 15 to 26 % of
/// `diagnose` (perf, 24,000 rows, seven joints, with and without a comparison of filters).
struct GramKernels {
  static constexpr std::size_t tile = 4;         ///< columns on either side
  static constexpr std::size_t widest_lane = 8;  ///< the number of rows is a multiple of it
  /// Adds the products of some columns with others to a matrix.
  /// @param left, right  first of their columns
  /// @param stride       from column to column
  /// @param count        rows of the matrix
  void (*add_tile)(const double* left, const double* right, std::size_t rows, std::size_t stride,
                   std::size_t count, double* out);
};

}  // namespace qerr
