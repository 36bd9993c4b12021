#include "qerr/bound/statistic.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

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

double percentile(double fraction, std::uint64_t count, const OrderStatistic& order) {
  const double position = fraction * static_cast<double>(count - 1);
  const auto below = static_cast<std::uint64_t>(position);
  const double part = position - static_cast<double>(below);
  const double high = part > 0 ? order(below + 1) : 0, low = order(below);
  if (part == 0) return low;
  return std::isinf(high) ? high : low + part * (high - low);
}

}  // namespace

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
