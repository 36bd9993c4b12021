#include "qerr/bound/figure.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "bound/batched_error.hpp"
#include "bound/histogram.hpp"
#include "bound/kernels.hpp"
#include "core/statistics.hpp"
#include "lanes/batch.hpp"

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

constexpr StatisticKind kinds[] = {
    {"min", "", "minimum", &Statistic::min},
    {"mean", "", "mean", &Statistic::mean},
    {"max", "max", "maximum", &Statistic::max},
    {"p50", "median", "median", &Statistic::p50, 0.50},
    {"p95", "p95", "95th percentile", &Statistic::p95, 0.95},
    {"p99", "p99", "99th percentile", &Statistic::p99, 0.99},
};

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
  for (const StatisticKind& kind : kinds)
    if (kind.percentile >= 0)
      for (const std::uint64_t rank : percentile_ranks(kind.percentile, count)) ranks.push_back(rank);
  return ranks;
}

Statistic statistic(const JoinedTally& t, const OrderStatistic& order) {
  Statistic s;
  if (t.count() == 0) return s;
  s.min = t.min();
  s.mean = t.mean();
  s.max = t.max();
  for (const StatisticKind& kind : kinds)
    if (kind.percentile >= 0) s.*kind.value = percentile(kind.percentile, t.count(), order);
  return s;
}

/// Two passes over the values: they are counted in bins of their leading bits, and those in the bins of the
/// ranks are kept. A quarter of the time of nth_element over all values (6.5 against 25 ns a value of 1e5).
OrderStatistic order_statistics(std::span<const double> values, const JoinedTally& tally) {
  constexpr int shift = 46;  // 64 bins an octave
  const auto bin_of = [](double value) { return std::bit_cast<std::uint64_t>(std::abs(value)) >> shift; };
  if (values.empty()) return [](std::uint64_t) { return 0.0; };
  const std::uint64_t first = bin_of(tally.min());
  std::vector<std::uint32_t> counts(bin_of(tally.max()) - first + 1);
  for (const double value : values) ++counts[bin_of(value) - first];
  struct Bin {
    std::uint64_t before;  // values of smaller bins
    std::vector<double> values = {};
  };
  std::map<std::uint64_t, Bin> kept;                                 // by the index of the bin
  std::vector<std::pair<std::uint64_t, std::uint64_t>> bin_of_rank;  // rank, bin
  for (const std::uint64_t rank : percentile_ranks(values.size())) {
    std::uint64_t before = 0, bin = 0;
    while (before + counts[bin] <= rank) before += counts[bin++];
    kept.insert({bin, {before}});
    bin_of_rank.emplace_back(rank, bin);
  }
  std::vector<Bin*> of_bin(counts.size());
  for (auto& [bin, of_ranks] : kept) of_bin[bin] = &of_ranks;
  for (const double value : values)
    if (Bin* const bin = of_bin[bin_of(value) - first]) bin->values.push_back(value);
  std::map<std::uint64_t, double> found;
  for (const auto& [rank, bin] : bin_of_rank) {
    auto& [before, near] = kept.at(bin);
    const auto nth = near.begin() + static_cast<std::ptrdiff_t>(rank - before);
    std::nth_element(near.begin(), nth, near.end());
    found[rank] = *nth;
  }
  return [found = std::move(found)](std::uint64_t rank) { return found.at(rank); };
}

LargestValues::LargestValues(std::size_t count, std::span<double> sample, std::size_t n)
    : count_(count), kept_(std::make_unique_for_overwrite<double[]>(4 * count + batch_size)) {
  // About count/n of the sample are wanted: binomial, so that four standard deviations more are enough.
  const double wanted = static_cast<double>(count) / static_cast<double>(n);
  const auto rank = static_cast<std::size_t>(wanted + 4 * std::sqrt(wanted) + 4);
  if (rank >= sample.size()) return;
  const auto nth = sample.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(sample.begin(), nth, sample.end(), std::greater<>());
  least_ = std::nextafter(*nth, -1);  // values that equal it count
}

void LargestValues::add(const BoundKernels& kernels, const double* batch, std::size_t count) {
  added_ += count;
  double* const kept = kept_.get();
  double* end = kept + size_;
  if (count == batch_size)
    end = kernels.append_larger(batch, least_, end);
  else
    end = std::copy_if(batch, batch + count, end, [&](double value) { return value > least_; });
  size_ = static_cast<std::size_t>(end - kept);
  if (size_ < 4 * count_) return;
  std::nth_element(kept, kept + (count_ - 1), end, std::greater<>());
  size_ = count_;
  least_ = kept[count_ - 1];
}

OrderStatistic LargestValues::order_statistics() && {
  return [kept = std::move(kept_), size = size_, last = added_ - 1](std::uint64_t rank) {
    double* const nth = kept.get() + (last - rank);
    std::nth_element(kept.get(), nth, kept.get() + size, std::greater<>());
    return *nth;
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
