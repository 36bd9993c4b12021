#pragma once

#include "kernels.hpp"
#include "qerr/core/batch.hpp"
#include "qerr/core/lanes.hpp"

namespace qerr::lanes {
namespace {

template <class L>
[[gnu::always_inline]] inline double largest(const double* values) {
  L high = load<L>(values);
  for (std::size_t i = lane_count<L>; i < batch_size; i += lane_count<L>)
    high = max(load<L>(values + i), high);
  double most = high[0];
#pragma GCC unroll 8
  for (std::size_t i = 1; i < lane_count<L>; ++i) most = high[i] > most ? high[i] : most;
  return most;
}

/// A batch with a maximum larger than before: looks for the configurations.
template <class L>
[[gnu::noinline]] void find_maxima(const double* figures, std::size_t count, std::uint64_t first,
                                   Tally* tallies) {
  for (std::size_t f = 0; f < count; ++f) {
    const double* const values = figures + f * batch_size;
    Tally& t = tallies[f];
    const double most = largest<L>(values);
    if (!(most > t.max)) continue;
    const bool is_another = most > same_maximum * t.max;
    t.max = most;
    for (std::size_t i = 0; i < batch_size && is_another; ++i)
      if (values[i] * same_maximum >= most) {
        t.at_max = first + i;
        break;
      }
  }
}

/// Bins of eight values. Of a double's bits the upper half is enough, and 32-bit numbers have minima and
/// maxima on every instruction set.
template <class Halves>
[[gnu::always_inline]] inline void put_bins(const Halves& halves, std::int64_t lowest, std::uint16_t* to) {
  typedef std::int32_t Bins __attribute__((vector_size(32)));
  typedef std::uint16_t Narrow __attribute__((vector_size(16)));
  static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__);
  Bins bin = __builtin_shufflevector(halves, halves, 1, 3, 5, 7, 9, 11, 13, 15) >> (bin_shift - 32);
  bin -= static_cast<std::int32_t>(lowest);
  bin = bin < 0 ? Bins{} : bin;
  bin = bin > static_cast<std::int32_t>(last_bin) ? Bins{} + static_cast<std::int32_t>(last_bin) : bin;
  const auto narrow = __builtin_convertvector(bin, Narrow);
  __builtin_memcpy(to, &narrow, sizeof narrow);
}

/// One figure on its way into its tally, eight values at a time.
template <class L>
class FigureTally {
 public:
  [[gnu::always_inline]] FigureTally(const TallyPlan& plan, double* figures, std::size_t f, Tally& tally)
      : values_(figures + f * batch_size),
        tally_(tally),
        root_(f - plan.first_root < plan.roots),
        bins_(plan.lowest ? plan.bins + f * plan.bin_stride : nullptr),
        lowest_(plan.lowest ? plan.lowest[f] : 0) {
    const BinBacklog& backlog = plan.backlog;
    if (const std::size_t chunk = backlog.next + f; chunk < backlog.end) {
      const std::size_t figure = chunk / batches_per_block;
      waiting_ = backlog.bins + figure * plan.bin_stride + chunk % batches_per_block * batch_size;
      counts_ = backlog.counts[figure];
    }
#pragma GCC unroll 8
    for (std::size_t p = 0; p < packs; ++p) {
      low_[p] = load<L>(tally.min + p * lane_count<L>);
      sum_[p] = load<L>(tally.sum + p * lane_count<L>);
      high_[p] = broadcast<L>(tally.max);
    }
  }

  [[gnu::always_inline]] void add(std::size_t i) {
    typedef std::int32_t Halves __attribute__((vector_size(64)));
    Halves halves;
#pragma GCC unroll 8
    for (std::size_t p = 0; p < packs; ++p) {
      double* const at = values_ + i + p * lane_count<L>;
      L value = load<L>(at);
      if (root_) {
        value = sqrt(value);
        store(at, value);
      }
      low_[p] = min(low_[p], value);
      high_[p] = max(high_[p], value);
      sum_[p] += value;
      if constexpr (packs == 1) halves = __builtin_bit_cast(Halves, value);
    }
    if (bins_) {
      if constexpr (packs > 1) __builtin_memcpy(&halves, values_ + i, sizeof halves);
      put_bins(halves, lowest_, bins_ + i);
    }
    if (!waiting_) return;
    count_four(waiting_ + i);
    count_four(waiting_ + i + 4);
  }

  /// @param news  gets true where the maximum is a new one
  [[gnu::always_inline]] void finish(Bits<L>& news) {
#pragma GCC unroll 8
    for (std::size_t p = 0; p < packs; ++p) {
      store(tally_.sum + p * lane_count<L>, sum_[p]);
      store(tally_.min + p * lane_count<L>, low_[p]);
      news |= high_[p] > broadcast<L>(tally_.max);
    }
  }

 private:
  static constexpr std::size_t packs = 8 / lane_count<L>;

  /// Four bins by one look at the memory, which counting itself keeps busy.
  [[gnu::always_inline]] void count_four(const std::uint16_t* bins) {
    std::uint64_t four;
    __builtin_memcpy(&four, bins, sizeof four);
#pragma GCC unroll 4
    for (int k = 0; k < 4; ++k) ++counts_[four >> (16 * k) & 0xFFFF];
  }

  double* values_;
  Tally& tally_;
  L low_[packs], high_[packs], sum_[packs];
  bool root_;
  std::uint16_t* bins_;
  std::int64_t lowest_;
  const std::uint16_t* waiting_ = nullptr;
  std::uint32_t* counts_ = nullptr;
};

/// Two figures at a time, of both halves of them: roots and counting, which are among them, keep different
/// units of the processor busy.
template <class L>
void tally(const TallyPlan& plan, double* figures, std::uint64_t first, Tally* tallies) {
  const std::size_t half = (plan.count + 1) / 2;
  Bits<L> news{};
  for (std::size_t f = 0; f < half; ++f) {
    FigureTally<L> a(plan, figures, f, tallies[f]);
    if (f + half == plan.count) {
      for (std::size_t i = 0; i < batch_size; i += 8) a.add(i);
      a.finish(news);
      break;
    }
    FigureTally<L> b(plan, figures, f + half, tallies[f + half]);
    for (std::size_t i = 0; i < batch_size; i += 8) {
      a.add(i);
      b.add(i);
    }
    a.finish(news);
    b.finish(news);
  }
  std::int64_t any = 0;
#pragma GCC unroll 8
  for (std::size_t i = 0; i < lane_count<L>; ++i) any |= news[i];
  if (any) find_maxima<L>(figures, plan.count, first, tallies);  // rare
}

}  // namespace
}  // namespace qerr::lanes
