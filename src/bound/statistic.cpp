#include "qerr/bound/statistic.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "bound/joined_tally.hpp"

namespace qerr {

void JoinedTally::append(const Tally& t, std::uint64_t count) {
  if (count == 0) return;
  for (const double lane : t.sum) sum_ += lane;
  for (const double lane : t.min) min_ = std::min(min_, lane);
  if (t.max > max_) {
    if (t.at_max != Tally::none && t.max > same_maximum * max_) at_max_ = t.at_max;
    max_ = t.max;
  }
  count_ += count;
}

double JoinedTally::mean() const {
  if (count_ == 0) return 0;
  return std::clamp(static_cast<double>(sum_ / static_cast<long double>(count_)), min(), max());
}

void tally_some(const double* values, std::size_t count, std::uint64_t first, Tally& t) {
  for (std::size_t i = 0; i < count; ++i) {
    t.sum[0] += values[i];
    t.min[0] = std::min(t.min[0], values[i]);
    if (!(values[i] > t.max)) continue;
    if (values[i] > same_maximum * t.max) t.at_max = first + i;
    t.max = values[i];
  }
}

namespace {

/// A percentile lies between two order statistics.
struct Place {
  std::uint64_t below;
  double part;  ///< of the way to the next one

  Place(double fraction, std::uint64_t count) {
    const double position = fraction * static_cast<double>(count - 1);
    below = static_cast<std::uint64_t>(position);
    part = position - static_cast<double>(below);
  }
};

double percentile(double fraction, std::uint64_t count, const OrderStatistic& order) {
  const Place at(fraction, count);
  const double high = at.part > 0 ? order(at.below + 1) : 0, low = order(at.below);
  if (at.part == 0) return low;
  return std::isinf(high) ? high : low + at.part * (high - low);
}

}  // namespace

std::vector<std::uint64_t> percentile_ranks(std::uint64_t count) {
  std::vector<std::uint64_t> ranks;
  for (const double fraction : {0.5, 0.95, 0.99}) {
    const Place at(fraction, count);
    ranks.push_back(at.below);
    if (at.part > 0) ranks.push_back(at.below + 1);
  }
  return ranks;
}

Statistic statistic(const JoinedTally& t, const OrderStatistic& order) {
  Statistic s;
  if (t.count() == 0) return s;
  s.min = t.min();
  s.mean = t.mean();
  s.max = t.max();
  s.p99 = percentile(0.99, t.count(), order);
  s.p95 = percentile(0.95, t.count(), order);
  s.p50 = percentile(0.50, t.count(), order);
  return s;
}

/// What stands behind a rank once found is never looked at again.
OrderStatistic order_statistics(double* values, std::uint64_t count) {
  return [values, end = count](std::uint64_t rank) mutable {
    if (rank >= end) end = rank + 1;
    std::nth_element(values, values + rank, values + end);
    end = rank + 1;
    return values[rank];
  };
}

}  // namespace qerr
