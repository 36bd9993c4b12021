#pragma once

#include <cstddef>

#include "lanes/select_kernels.hpp"

// Interface of the kernels of the scan for periods (a periodogram). Files that are compiled per instruction
// set include this, and nothing that contains code of its own. Lanes are rows.

namespace qerr {

/// The number of rows is a multiple of this; padding rows have score 0.
inline constexpr std::size_t scanned_together = 32;

struct ScanKernels {
  /// powers[i] = |sum_k score[k] e^{j (first + i) angle[k]}|^2, i = 0 .. count - 1.
  ///
  /// e^{j n angle} of a row is computed by the recursion over n, with a rounding error up to n 2e-16.
  /// @param scratch  4 rows + 2 scanned_at_once 8 doubles
  void (*powers)(const double* score, const double* angle, std::size_t rows, double first, std::size_t count,
                 double* scratch, double* powers);
  /// |sum_k score[k] e^{j rate argument[k]}|^2.
  double (*power)(const double* score, const double* argument, std::size_t rows, double rate);
};

/// Number of powers per block, whose sums stay in the first-level cache.
inline constexpr std::size_t scanned_at_once = 64;

}  // namespace qerr
