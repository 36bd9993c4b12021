#include "deferred_counts.hpp"

#include <algorithm>
#include <utility>

namespace qerr {

namespace {

/// Of a figure's bins; not a power of two, or those of all figures would want the same lines of the cache.
constexpr std::size_t stride = DeferredCounts::block_size + batch_size;

}  // namespace

DeferredCounts::DeferredCounts(const std::vector<std::int64_t>& lowest_bins)
    : lowest_(lowest_bins),
      filling_(lowest_bins.size() * stride),
      waiting_(filling_.size()),
      counts_(lowest_bins.size()) {
  for (const std::int64_t lowest : lowest_) histograms_.emplace_back(lowest);
}

void DeferredCounts::plan(std::size_t batch, TallyPlan& tally) {
  tally.lowest = lowest_.data();
  tally.bins = filling_.data() + batch * batch_size;
  tally.bin_stride = stride;
  const std::size_t first = counted_;
  counted_ = std::min(counted_ + histograms_.size(), chunks_);
  tally.backlog = {waiting_.data(), counts_.data(), first, counted_};
}

void DeferredCounts::end_of_block(std::size_t count) {
  count_waiting();
  if (count < block_size) {
    for (std::size_t f = 0; f < histograms_.size(); ++f)
      histograms_[f].add(filling_.data() + f * stride, count);
    return;
  }
  std::swap(filling_, waiting_);
  for (std::size_t f = 0; f < histograms_.size(); ++f) counts_[f] = histograms_[f].counts_for(block_size);
  chunks_ = histograms_.size() * batches_per_block;
  counted_ = 0;
}

std::vector<Histogram> DeferredCounts::finish() {
  count_waiting();
  return std::move(histograms_);
}

void DeferredCounts::count_waiting() {
  for (; counted_ < chunks_; ++counted_) {
    const std::size_t figure = counted_ / batches_per_block;
    const std::uint16_t* const bins =
        waiting_.data() + figure * stride + counted_ % batches_per_block * batch_size;
    for (std::size_t i = 0; i < batch_size; ++i) ++counts_[figure][bins[i]];
  }
}

}  // namespace qerr
