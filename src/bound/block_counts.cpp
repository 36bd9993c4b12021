#include "bound/block_counts.hpp"

#include <utility>

namespace qerr {

BlockCounts::BlockCounts(std::vector<Histogram> empty)
    : histograms_(std::move(empty)),
      bins_(std::make_unique_for_overwrite<std::int32_t[]>(histograms_.size() * (block_size + batch_size))),
      lists_(histograms_.size()) {
  for (std::size_t f = 0; f < lists_.size(); ++f) {
    lists_[f].counted = histograms_[f].counted();
    lists_[f].next = list(f);
  }
}

void BlockCounts::end_of_block(std::uint64_t values) {
  for (std::size_t f = 0; f < lists_.size(); ++f) {
    BinList& bins = lists_[f];
    const auto listed = static_cast<std::size_t>(bins.next - list(f));
    std::uint64_t below = 0;
    for (std::int32_t& lane : bins.below) below += static_cast<std::uint64_t>(std::exchange(lane, 0));
    histograms_[f].add(list(f), listed, below, values - listed - below);
    bins.next = list(f);
  }
}

}  // namespace qerr
