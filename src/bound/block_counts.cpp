#include "block_counts.hpp"

#include <utility>

namespace qerr {

BlockCounts::BlockCounts(std::vector<Histogram> empty)
    : histograms_(std::move(empty)),
      bins_(histograms_.size() * (block_size + batch_size)),
      lists_(histograms_.size()) {
  for (std::size_t f = 0; f < lists_.size(); ++f) {
    lists_[f].counted = histograms_[f].counted();
    lists_[f].next = begin(f);
  }
}

void BlockCounts::end_of_block(std::uint64_t values) {
  for (std::size_t f = 0; f < lists_.size(); ++f) {
    BinList& list = lists_[f];
    const auto listed = static_cast<std::size_t>(list.next - begin(f));
    std::uint64_t below = 0;
    for (std::int32_t& of_lane : list.below) below += static_cast<std::uint64_t>(std::exchange(of_lane, 0));
    histograms_[f].add(begin(f), listed, below, values - listed - below);
    list.next = begin(f);
  }
}

}  // namespace qerr
