#include "bound/sampled_bins.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "qerr/bound/statistic.hpp"

namespace qerr {

SampledBins::SampledBins(const std::int32_t* begin, const std::int32_t* end)
    : count_(static_cast<std::uint64_t>(end - begin)) {
  const std::int32_t infinite = leading_bits(std::numeric_limits<double>::infinity());
  std::int32_t smallest = infinite, beyond = CountedBins::first;
  for (const std::int32_t* bin = begin; bin != end; ++bin) {
    smallest = std::min(smallest, *bin);
    if (*bin < infinite) beyond = std::max(beyond, *bin + 1);
  }
  if (smallest == infinite) beyond = infinite;  // all values are infinite
  first_ = std::max(smallest, beyond - static_cast<std::int32_t>(bin_count));
  counts_.resize(static_cast<std::size_t>(beyond - first_ + 1));
  for (const std::int32_t* bin = begin; bin != end; ++bin)
    ++counts_[static_cast<std::size_t>(std::clamp(*bin, first_, beyond) - first_)];
}

std::int32_t SampledBins::operator[](std::uint64_t rank) const {
  std::size_t bin = 0;
  for (std::uint64_t before = counts_[0]; before <= rank; before += counts_[bin]) ++bin;
  return first_ + static_cast<std::int32_t>(bin);
}

CountedBins SampledBins::near_percentiles() const {
  constexpr double deviations = 4.5;  // P(beyond) = 3.4e-6
  const auto n = static_cast<double>(count_);
  const auto edge = [&](double fraction, double side) {
    const double distance = deviations * std::sqrt(n * fraction * (1 - fraction));
    return (*this)[static_cast<std::uint64_t>(std::clamp(n * fraction + side * distance, 0.0, n - 1))];
  };
  // The first bin includes all smaller values.
  const auto from = [&](std::int32_t bin) { return bin == first_ ? CountedBins::first : bin; };
  std::vector<double> fractions;
  for (const StatisticKind& kind : statistic_kinds())
    if (kind.percentile >= 0) fractions.push_back(kind.percentile);
  std::sort(fractions.begin(), fractions.end());
  const double lowest = fractions.front(), next = fractions[fractions.size() > 1];
  return {from(edge(lowest, -1)), edge(lowest, 1) + 1, from(edge(next, -1))};
}

Histogram::Usual SampledBins::usual() const {
  constexpr std::int32_t octave = 1 << (52 - bin_shift);
  return {first_, static_cast<std::int32_t>(counts_.size()) + octave};
}

}  // namespace qerr
