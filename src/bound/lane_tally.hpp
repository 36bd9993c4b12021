#pragma once

#include "qerr/bound/bins.hpp"
#include "qerr/bound/tally.hpp"
#include "qerr/core/batch.hpp"
#include "qerr/core/lanes.hpp"

namespace qerr::lanes {
namespace {

/// A batch with a maximum larger than before: looks for the configurations.
[[gnu::noinline]] inline void find_maxima(const double* figures, std::size_t count, std::uint64_t first,
                                          Tally* tallies) {
  for (std::size_t f = 0; f < count; ++f) {
    const double* const values = figures + f * batch_size;
    Tally& t = tallies[f];
    double most = t.max;
    for (std::size_t i = 0; i < batch_size; ++i) most = values[i] > most ? values[i] : most;
    const bool is_another = most > same_maximum * t.max;
    t.max = most;
    for (std::size_t i = 0; i < batch_size && is_another; ++i)
      if (values[i] * same_maximum >= most) {
        t.at_max = first + i;
        break;
      }
  }
}

template <class L>
void tally(const double* figures, std::size_t count, std::uint64_t first, Tally* tallies) {
  Bits<L> news{};
  for (std::size_t f = 0; f < count; ++f) {
    const double* const values = figures + f * batch_size;
    Tally& t = tallies[f];
    L low = load<L>(t.min), high = broadcast<L>(t.max), sum = load<L>(t.sum);
    const L most = high;
#pragma GCC unroll 32
    for (std::size_t i = 0; i < batch_size; i += lane_count<L>) {
      const L value = load<L>(values + i);
      low = min(low, value);
      high = max(high, value);
      sum += value;
    }
    store(t.sum, sum);
    store(t.min, low);
    news |= high > most;
  }
  std::int64_t any = 0;
#pragma GCC unroll 8
  for (std::size_t i = 0; i < lane_count<L>; ++i) any |= news[i];
  if (any) find_maxima(figures, count, first, tallies);  // rare
}

/// Eight at a time whatever the lanes: of a double's bits the upper half is enough, and 32-bit numbers have
/// minima and maxima on every instruction set.
void bins(const double* figures, std::size_t count, const std::int64_t* lowest, std::uint16_t* keys,
          std::size_t stride) {
  typedef std::int32_t Halves __attribute__((vector_size(64)));
  typedef std::int32_t Bins __attribute__((vector_size(32)));
  typedef std::uint16_t Narrow __attribute__((vector_size(16)));
  static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__);
  for (std::size_t f = 0; f < count; ++f)
#pragma GCC unroll 4
    for (std::size_t i = 0; i < batch_size; i += 8) {
      Halves halves;
      __builtin_memcpy(&halves, figures + f * batch_size + i, sizeof halves);
      Bins bin = __builtin_shufflevector(halves, halves, 1, 3, 5, 7, 9, 11, 13, 15) >> (bin_shift - 32);
      bin -= static_cast<std::int32_t>(lowest[f]);
      bin = bin < 0 ? Bins{} : bin;
      bin = bin > static_cast<std::int32_t>(last_bin) ? Bins{} + static_cast<std::int32_t>(last_bin) : bin;
      const auto narrow = __builtin_convertvector(bin, Narrow);
      __builtin_memcpy(keys + f * stride + i, &narrow, sizeof narrow);
    }
}

}  // namespace
}  // namespace qerr::lanes
