#pragma once

#include <cstddef>

#include "lanes/dispatch.hpp"

// What the kernels of the scans for periods take; files that are compiled per instruction set include this,
// and nothing that has code of its own. Lanes are rows.

namespace qerr {

/// Rows come in multiples of this many: those that are none have a score of 0.
inline constexpr std::size_t scanned_together = 32;

struct ScanKernels {
  /// powers[i] = |sum_k score[k] e^{j (first + i) angle[k]}|^2, i = 0 .. count - 1.
  ///
  /// Every row's e^{j n angle} goes from one n to the next by a product, whose errors add up to n 2e-16.
  /// @param room  4 rows + 2 scanned_at_once 8 numbers
  void (*powers)(const double* score, const double* angle, std::size_t rows, double first, std::size_t count,
                 double* room, double* powers);
  /// |sum_k score[k] e^{j rate argument[k]}|^2.
  double (*power)(const double* score, const double* argument, std::size_t rows, double rate);
};

/// Powers whose sums are kept in the first-level cache at a time.
inline constexpr std::size_t scanned_at_once = 64;

}  // namespace qerr
