#include "bound/column_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "bound/form_statistics.hpp"
#include "bound/joined_tally.hpp"
#include "core/parallel.hpp"
#include "core/random.hpp"
#include "lanes/aligned.hpp"

namespace qerr {

namespace {

/// Power of two that brings a number that is not negative between 1/2 and 1; 1 for 0.
double scale_of(double largest) {
  int exponent = 0;
  if (largest > 0) std::frexp(largest, &exponent);
  return std::ldexp(1.0, -exponent);
}

/// Places in random order: what comes first is a sample, also of a grid or of Sobol's sequence.
std::vector<std::int32_t> shuffled(std::size_t count) {
  std::vector<std::int32_t> order(count);
  std::iota(order.begin(), order.end(), 0);
  for (std::size_t i = count; i > 1; --i) std::swap(order[i - 1], order[random_bits(0, i, 0) % i]);
  return order;
}

std::vector<std::uint64_t> ranks_of(const WantedStatistics& wanted, std::uint64_t count) {
  std::vector<std::uint64_t> ranks;
  if (wanted.min) ranks.push_back(0);
  if (wanted.max) ranks.push_back(count - 1);
  for (const StatisticKind* kind : wanted.percentiles)
    for (const std::uint64_t rank : percentile_ranks(kind->percentile, count)) ranks.push_back(rank);
  std::sort(ranks.begin(), ranks.end());
  ranks.erase(std::unique(ranks.begin(), ranks.end()), ranks.end());
  return ranks;
}

}  // namespace

WantedStatistics WantedStatistics::of(const std::vector<const StatisticKind*>& kinds) {
  WantedStatistics wanted{false, false, false, {}};
  for (const StatisticKind* kind : kinds) {
    if (kind->value == &Statistic::min) wanted.min = true;
    if (kind->value == &Statistic::mean) wanted.mean = true;
    if (kind->value == &Statistic::max) wanted.max = true;
    if (kind->percentile >= 0) wanted.percentiles.push_back(kind);
  }
  return wanted;
}

ColumnStatistics::ColumnStatistics(const ErrorColumns& columns, WantedStatistics wanted, unsigned threads,
                                   InstructionSet set)
    : columns_(columns),
      wanted_(std::move(wanted)),
      kernels_(select_kernels<ScreenKernels>(set)),
      configurations_(columns.configurations()),
      padded_((configurations_ + batch_size - 1) / batch_size * batch_size),
      count_(columns.columns()),
      row_size_(columns.coordinates() * count_ + columns.joints()),
      ranks_(ranks_of(wanted_, configurations_)),
      order_(shuffled(configurations_)),
      scale_(columns.coordinates()),
      constant_(columns.coordinates()),
      floats_(2 * columns.coordinates() * count_ * padded_),
      rows_(row_size_ * configurations_),
      mean_(columns.coordinates() * count_),
      mean_square_(mean_.size()),
      mean_norm_(columns.joints()),
      least_norm_(columns.joints()),
      largest_norm_(columns.joints()) {
  parallel_for(columns.coordinates(), threads, [&](std::size_t c) { fill(c); });
  for (std::size_t j = 0; j < columns.joints(); ++j) {
    const double* const norms = columns.norms(j);
    long double sum = 0;
    for (std::size_t i = 0; i < configurations_; ++i) {
      sum += norms[i];
      rows_[i * row_size_ + columns.coordinates() * count_ + j] = norms[order_[i]];
    }
    mean_norm_[j] = static_cast<double>(sum / static_cast<long double>(configurations_));
    const auto [least, largest] = std::minmax_element(norms, norms + configurations_);
    least_norm_[j] = *least;
    largest_norm_[j] = *largest;
  }
}

void ColumnStatistics::fill(std::size_t c) {
  double largest = 0;
  for (std::size_t k = 0; k < count_; ++k)
    for (std::size_t i = 0; i < configurations_; ++i)
      largest = std::max(largest, std::abs(columns_.column(c, k)[i]));
  scale_[c] = scale_of(largest);
  float* const linear = floats_.data() + 2 * c * count_ * padded_;
  float* const squared = linear + count_ * padded_;
  constant_[c] = true;
  for (std::size_t k = 0; k < count_; ++k) {
    const double* const column = columns_.column(c, k);
    long double sum = 0, square_sum = 0;
    double least = std::numeric_limits<double>::infinity(), most = 0;
    for (std::size_t i = 0; i < configurations_; ++i) {
      const double a = std::abs(column[order_[i]]), scaled = a * scale_[c];
      const std::size_t to = (i / batch_size * count_ + k) * batch_size + i % batch_size;
      linear[to] = static_cast<float>(scaled);
      squared[to] = static_cast<float>(scaled * scaled);
      rows_[i * row_size_ + c * count_ + k] = a;
      sum += a;
      square_sum += static_cast<long double>(a) * a;
      least = std::min(least, a);
      most = std::max(most, a);
    }
    mean_[c * count_ + k] = static_cast<double>(sum / static_cast<long double>(configurations_));
    mean_square_[c * count_ + k] =
        static_cast<double>(square_sum / static_cast<long double>(configurations_));
    // Differences of rounding in trigonometry and the lengths of links.
    constant_[c] = constant_[c] && most - least <= 1e-14 * largest;
  }
}

void ColumnStatistics::evaluate(std::size_t coordinate, bool squared,
                                std::span<const ColumnForm> forms) const {
  FormStatistics tile(*this, coordinate, squared);
  for (std::size_t first = 0; first < forms.size(); first += forms_per_tile)
    tile.evaluate(forms.subspan(first, std::min(forms_per_tile, forms.size() - first)));
}

}  // namespace qerr
