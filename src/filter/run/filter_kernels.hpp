#pragma once

#include <cstddef>

#include "filter/run/section_recursion.hpp"

// The table of kernels of RowFilter; the kernel source includes this, and nothing that has code of its own.
// Lanes are channels: neighbours in a row, of `width` numbers, a multiple of the lanes.

namespace qerr {

struct FilterKernels {
  /// Rows `stride` numbers apart through a section, into rows `width` apart.
  /// @param state  [s1, s2][width]
  /// @param out  may be `in` where stride = width
  void (*section)(const NormalizedSection<double>&, const double* in, std::size_t stride, std::size_t rows,
                  std::size_t width, double* state, double* out);
  /// out[row] = sum_k taps[k] in[row - k].
  /// @param in  the row of the first output; the `count` - 1 rows before it precede it in memory
  void (*taps)(const double* taps, std::size_t count, const double* in, std::size_t rows, std::size_t width,
               double* out);
};

}  // namespace qerr
