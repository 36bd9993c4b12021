#include "qerr/bound/figure.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "bound/figure_column.hpp"
#include "bound/joined_tally.hpp"
#include "core/statistics.hpp"

namespace qerr {

namespace {

struct BoundRow {
  std::string_view name, summary;
};

/// In the order of the enumeration.
constexpr std::array<BoundRow, 5> bound_rows{
    {{"worst_case", "largest error of the linearized kinematics; behind a filter with its l1 norm"},
     {"worst_case_rigorous", "the same plus the linearization remainder: no error exceeds it"},
     {"sigma", "standard deviation, errors of encoders independent (IPQN); behind a filter with its H2 norm"},
     {"sigma_quantization", "sigma of quantization alone, without accuracies and effects"},
     {"sigma_in_motion", "root mean square along `motion:`, over all zeros of the encoders"}}};

}  // namespace

std::span<const Bound> bounds_of(bool behind_filter) {
  static constexpr std::array of_position{Bound::worst_case, Bound::worst_case_rigorous, Bound::sigma};
  static constexpr std::array of_filter{Bound::worst_case, Bound::sigma, Bound::sigma_quantization,
                                        Bound::sigma_in_motion};
  if (behind_filter) return of_filter;
  return of_position;
}

std::string_view name_of(Bound b) { return bound_rows[static_cast<std::size_t>(b)].name; }

std::string_view summary_of(Bound b) { return bound_rows[static_cast<std::size_t>(b)].summary; }

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

constexpr StatisticKind kinds[] = {
    {"min", "", "minimum", &Statistic::min},
    {"mean", "", "mean", &Statistic::mean},
    {"max", "max", "maximum", &Statistic::max},
    {"p50", "median", "median", &Statistic::p50, 0.50},
    {"p95", "p95", "95th percentile", &Statistic::p95, 0.95},
    {"p99", "p99", "99th percentile", &Statistic::p99, 0.99},
};

/// Rows of percentiles, the largest first.
std::vector<const StatisticKind*> percentiles() {
  std::vector<const StatisticKind*> rows;
  for (const StatisticKind& kind : kinds)
    if (kind.percentile >= 0) rows.push_back(&kind);
  std::sort(rows.begin(), rows.end(), [](auto* a, auto* b) { return a->percentile > b->percentile; });
  return rows;
}

}  // namespace

std::span<const StatisticKind> statistic_kinds() { return kinds; }

const StatisticKind* find_statistic(std::string_view name) {
  for (const StatisticKind& kind : kinds)
    if (kind.name == name) return &kind;
  return nullptr;
}

Statistic scaled(const Statistic& s, double factor) {
  Statistic product = s;
  for (const StatisticKind& kind : kinds) product.*kind.value *= factor;
  return product;
}

double percentile(double fraction, std::uint64_t count, const OrderStatistic& order) {
  const PercentileRank rank(fraction, count);
  const double high = rank.part > 0 ? order(rank.below + 1) : 0, low = order(rank.below);
  if (rank.part == 0) return low;
  return std::isinf(high) ? high : low + rank.part * (high - low);
}

std::vector<std::uint64_t> percentile_ranks(double fraction, std::uint64_t count) {
  const PercentileRank rank(fraction, count);
  if (rank.part > 0) return {rank.below, rank.below + 1};
  return {rank.below};
}

std::vector<std::uint64_t> percentile_ranks(std::uint64_t count) {
  std::vector<std::uint64_t> ranks;
  for (const StatisticKind* kind : percentiles())
    for (const std::uint64_t rank : percentile_ranks(kind->percentile, count)) ranks.push_back(rank);
  return ranks;
}

Statistic statistic(const JoinedTally& t, const OrderStatistic& order) {
  Statistic s;
  if (t.count() == 0) return s;
  s.min = t.min();
  s.mean = t.mean();
  s.max = t.max();
  // In descending order, as `order_statistics` requires.
  for (const StatisticKind* kind : percentiles())
    s.*kind->value = percentile(kind->percentile, t.count(), order);
  return s;
}

/// Ranks are requested in descending order: values above the last one are not visited again.
OrderStatistic order_statistics(double* values, std::uint64_t count) {
  return [values, end = count](std::uint64_t rank) mutable {
    if (rank >= end) end = rank + 1;
    std::nth_element(values, values + rank, values + end);
    end = rank + 1;
    return values[rank];
  };
}

FigureColumn figure_column(const Figure& f, const std::vector<Norms>& filters, const FigureLayout& at) {
  const std::size_t c = f.signal;
  if (f.filter < 0)
    return {(f.bound == Bound::worst_case            ? at.worst_case
             : f.bound == Bound::worst_case_rigorous ? at.rigorous
                                                     : at.sigma) +
                c,
            1};
  const auto filter = static_cast<std::size_t>(f.filter);
  const std::size_t behind = filter * at.coordinates + c;
  const Norms& norms = filters[filter];
  // Of other errors there is one more filter, behind which is nothing but quantization.
  if (f.bound == Bound::sigma_quantization && at.in_motion > at.filtered_sigma)
    return {at.filtered_sigma + filters.size() * at.coordinates + c, norms.h2};
  if (f.bound == Bound::sigma_in_motion) return {at.in_motion + behind, 1};
  if (f.bound == Bound::worst_case)
    return at.filtered_sigma > at.filtered_worst ? FigureColumn{at.filtered_worst + behind, 1}
                                                 : FigureColumn{at.worst_case + c, norms.l1.upper};
  return at.in_motion > at.filtered_sigma ? FigureColumn{at.filtered_sigma + behind, 1}
                                          : FigureColumn{at.sigma + c, norms.h2};
}

}  // namespace qerr
