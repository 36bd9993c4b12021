#pragma once

#include <utility>

#include "lanes/batch.hpp"
#include "lanes/lanes.hpp"

// Transposes numbers of many instants from channels into rows, and sums them.

namespace qerr::lanes {
namespace {

/// One step of transposing a square of lanes: exchanges blocks of rows `a` and `b`, which are `distance`
/// apart.
template <std::size_t distance, class L, std::size_t... i>
[[gnu::always_inline]] inline void cross_over(L& a, L& b, std::index_sequence<i...>) {
  constexpr auto n = sizeof...(i);
  const L first = __builtin_shufflevector(a, b, (i & distance ? n + i - distance : i)...);
  b = __builtin_shufflevector(a, b, (i & distance ? n + i : i + distance)...);
  a = first;
}

template <std::size_t distance, class L>
[[gnu::always_inline]] inline void cross_rows(L* rows) {
  constexpr auto n = lane_count<L>;
#pragma GCC unroll 8
  for (std::size_t row = 0; row < n; ++row)
    if (!(row & distance))
      cross_over<distance>(rows[row], rows[row + distance], std::make_index_sequence<n>{});
  if constexpr (distance > 1) cross_rows<distance / 2>(rows);
}

/// Transposes channels of one vector of instants, `stride` numbers apart, into rows of `width` channels.
template <class L>
[[gnu::always_inline]] inline void into_rows(const double* channels, std::size_t stride, std::size_t width,
                                             double* rows) {
  constexpr auto n = lane_count<L>;
  for (std::size_t c = 0; c < width; c += n) {
    L square[n];
#pragma GCC unroll 8
    for (std::size_t i = 0; i < n; ++i) square[i] = load<L>(channels + (c + i) * stride);
    cross_rows<n / 2>(square);
#pragma GCC unroll 8
    for (std::size_t i = 0; i < n; ++i) store(rows + i * width + c, square[i]);
  }
}

template <class L>
[[gnu::always_inline]] inline double sum_of(const L& lanes) {
  double sum = 0;
  for (std::size_t i = 0; i < lane_count<L>; ++i) sum += lanes[i];
  return sum;
}

template <class L>
double sum_between(const double* row, std::size_t first, std::size_t last) {
  constexpr auto lanes = lane_count<L>;
  L sum{};
  for (; first + lanes <= last; first += lanes) sum += load<L>(row + first);
  double all = sum_of(sum);
  for (; first < last; ++first) all += row[first];
  return all;
}

}  // namespace
}  // namespace qerr::lanes
