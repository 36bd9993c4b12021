#include "sorted_bins.hpp"

#include <algorithm>
#include <cmath>

namespace qerr {

SortedBins::SortedBins(const std::int32_t* begin, const std::int32_t* end)
    : count_(static_cast<std::uint64_t>(end - begin)) {
  const auto [smallest, largest] = std::minmax_element(begin, end);
  // Nobody asks what lies so far below.
  first_ = std::max(*smallest, *largest - static_cast<std::int32_t>(bin_count));
  counts_.resize(static_cast<std::size_t>(*largest - first_ + 1));
  for (const std::int32_t* bin = begin; bin != end; ++bin)
    ++counts_[static_cast<std::size_t>(std::max(*bin, first_) - first_)];
}

std::int32_t SortedBins::operator[](std::uint64_t rank) const {
  std::size_t at = 0;
  for (std::uint64_t before = counts_[0]; before <= rank; before += counts_[at]) ++at;
  return first_ + static_cast<std::int32_t>(at);
}

CountedBins SortedBins::near_percentiles() const {
  constexpr double deviations = 4.5;
  const auto n = static_cast<double>(count_);
  const auto edge = [&](double fraction, double side) {
    const double off = deviations * std::sqrt(n * fraction * (1 - fraction));
    return (*this)[static_cast<std::uint64_t>(std::clamp(n * fraction + side * off, 0.0, n - 1))];
  };
  return {edge(0.5, -1), edge(0.5, 1) + 1, edge(0.95, -1)};
}

Histogram::Usual SortedBins::usual(const CountedBins& counted) const {
  constexpr std::int32_t octave = 1 << (52 - bin_shift);
  const std::int32_t first = std::max(first_, counted.begin);
  return {first, first_ + static_cast<std::int32_t>(counts_.size()) + octave - first};
}

}  // namespace qerr
