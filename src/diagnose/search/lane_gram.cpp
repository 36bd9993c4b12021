#include "diagnose/search/gram_kernels.hpp"
#include "lanes/select_kernels.hpp"

namespace qerr::lanes {
namespace {

/// Columns on the right at a time: the sums, which keep both multipliers busy, and their factors fit into the
/// registers, of which 512-bit lanes have 32, others 16.
template <class L>
constexpr std::size_t width = lane_count<L> == 8 ? GramKernels::tile : 2;

template <class L>
void add_tile(const double* left, const double* right, std::size_t rows, std::size_t stride,
              std::size_t count, double* out) {
  static_assert(GramKernels::tile == 4);
  for (std::size_t first = 0; first < 4; first += width<L>) {
    const double* const of = right + first * stride;
    L sum[4][width<L>] = {};
    for (std::size_t k = 0; k < rows; k += lane_count<L>) {
      L b[width<L>];
#pragma GCC unroll 4
      for (std::size_t j = 0; j < width<L>; ++j) b[j] = load<L>(of + j * stride + k);
#pragma GCC unroll 4
      for (std::size_t i = 0; i < 4; ++i) {
        const L a = load<L>(left + i * stride + k);
#pragma GCC unroll 4
        for (std::size_t j = 0; j < width<L>; ++j) sum[i][j] = fma(a, b[j], sum[i][j]);
      }
    }
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < width<L>; ++j) {
        double total = 0;
        for (std::size_t lane = 0; lane < lane_count<L>; ++lane) total += sum[i][j][lane];
        out[(first + j) * count + i] += total;
      }
  }
}

}  // namespace
}  // namespace qerr::lanes

namespace qerr {

template <>
const GramKernels& compiled_kernels<GramKernels, lanes::compiled_set>() {
  static constexpr GramKernels kernels{lanes::add_tile<lanes::CompiledLanes>};
  return kernels;
}

}  // namespace qerr
