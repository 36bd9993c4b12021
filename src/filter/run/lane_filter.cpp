#include "filter/run/section_recursion.hpp"
#include "lanes/select_kernels.hpp"

namespace qerr::lanes {
namespace {

/// One section on `group` vectors of channels, row after row. The states stay in registers, and the vectors
/// of a group hide the latency of the recursion of each.
template <class L, int group, bool second>
void section_on(const NormalizedSection<double>& s, const double* in, std::size_t stride, std::size_t rows,
                std::size_t width, double* state, double* out) {
  constexpr auto lanes = lane_count<L>;
  // Hoisted: stores may alias.
  const L k0 = broadcast<L>(s.k0), k1 = broadcast<L>(s.k1);
  const L b0 = broadcast<L>(s.b0), b1 = broadcast<L>(s.b1), b2 = broadcast<L>(s.b2);
  SectionState<L> of[group];
#pragma GCC unroll 8
  for (int g = 0; g < group; ++g) {
    of[g].s1 = load<L>(state + g * lanes);
    if constexpr (second) of[g].s2 = load<L>(state + width + g * lanes);
  }
  for (std::size_t row = 0; row < rows; ++row, in += stride, out += width) {
#pragma GCC unroll 8
    for (int g = 0; g < group; ++g)
      store(out + g * lanes,
            output<second>(b0, b1, b2, advance<second>(k0, k1, load<L>(in + g * lanes), of[g])));
  }
#pragma GCC unroll 8
  for (int g = 0; g < group; ++g) {
    store(state + g * lanes, of[g].s1);
    if constexpr (second) store(state + width + g * lanes, of[g].s2);
  }
}

/// Vectors of a group: as many as the registers hold with the states and factors.
template <class L>
constexpr int largest_group = lane_count<L> == 8 ? 8 : 4;

template <class L>
void section(const NormalizedSection<double>& s, const double* in, std::size_t stride, std::size_t rows,
             std::size_t width, double* state, double* out) {
  in_groups<largest_group<L>, L>(0, width, [&]<int group>(std::size_t c) {
    s.second ? section_on<L, group, true>(s, in + c, stride, rows, width, state + c, out + c)
             : section_on<L, group, false>(s, in + c, stride, rows, width, state + c, out + c);
  });
}

template <class L>
void taps(const double* taps, std::size_t count, const double* in, std::size_t rows, std::size_t width,
          double* out) {
  for (std::size_t row = 0; row < rows; ++row)
    for (std::size_t c = 0; c < width; c += lane_count<L>) {
      L sum{};
      const double* from = in + row * width + c;
      for (std::size_t k = 0; k < count; ++k, from -= width) sum = fma(taps[k], load<L>(from), sum);
      store(out + row * width + c, sum);
    }
}

}  // namespace
}  // namespace qerr::lanes

namespace qerr {

template <>
const FilterKernels& compiled_kernels<FilterKernels, lanes::compiled_set>() {
  using L = lanes::CompiledLanes;
  static constexpr FilterKernels kernels{lanes::section<L>, lanes::taps<L>};
  return kernels;
}

}  // namespace qerr
