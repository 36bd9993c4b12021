#pragma once

#include <cstddef>

#include "lanes/select_kernels.hpp"

// Interface of the kernel of a Gram matrix. Files that are compiled per instruction set include this, and
// nothing that contains code of its own.

namespace qerr {

/// In Eigen's code, which is compiled for the baseline of the architecture, these products were 15 to 26 % of
/// `diagnose` (perf, 24,000 rows, seven joints, with and without a comparison of filters).
struct GramKernels {
  static constexpr std::size_t tile = 4;         ///< the number of columns is a multiple of it
  static constexpr std::size_t widest_lane = 8;  ///< the number of rows is a multiple of it
  /// Adds the lower triangle of Z^T Z to `out`, count x count numbers.
  /// @param z  column by column
  void (*add_gram)(const double* z, std::size_t rows, std::size_t count, double* out);
};

}  // namespace qerr
