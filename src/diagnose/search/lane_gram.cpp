#include <algorithm>

#include "diagnose/search/gram_kernels.hpp"
#include "lanes/compiled_set.hpp"

namespace qerr::lanes {
namespace {

/// Products of four columns with two: eight sums keep both multipliers busy, and fit into 16 registers.
template <class L>
[[gnu::always_inline]] inline void add_tile(const double* left, const double* right, std::size_t rows,
                                            std::size_t stride, std::size_t count, double* out) {
  L sum[4][2] = {};
  for (std::size_t k = 0; k < rows; k += lane_count<L>) {
    const L b[2] = {load<L>(right + k), load<L>(right + stride + k)};
#pragma GCC unroll 4
    for (std::size_t i = 0; i < 4; ++i) {
      const L a = load<L>(left + i * stride + k);
      sum[i][0] = fma(a, b[0], sum[i][0]);
      sum[i][1] = fma(a, b[1], sum[i][1]);
    }
  }
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 2; ++j) {
      double total = 0;
      for (std::size_t lane = 0; lane < lane_count<L>; ++lane) total += sum[i][j][lane];
      out[j * count + i] += total;
    }
}

template <class L>
void add_gram(const double* z, std::size_t rows, std::size_t count, double* out) {
  constexpr std::size_t block = 512;  // rows: some hundred columns of them stay in the second-level cache
  for (std::size_t first = 0; first < rows; first += block)
    for (std::size_t i = 0; i < count; i += 4)
      for (std::size_t j = 0; j < i + 4; j += 2)
        add_tile<L>(z + i * rows + first, z + j * rows + first, std::min(block, rows - first), rows, count,
                    out + j * count + i);
}

}  // namespace
}  // namespace qerr::lanes

namespace qerr {

template <>
const GramKernels& compiled_kernels<GramKernels, lanes::compiled_set>() {
  static constexpr GramKernels kernels{lanes::add_gram<lanes::CompiledLanes>};
  return kernels;
}

}  // namespace qerr
