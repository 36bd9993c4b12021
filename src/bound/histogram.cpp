#include "bound/histogram.hpp"

#include <algorithm>
#include <bit>

namespace qerr {

namespace {

constexpr int octave = 52 - bin_shift;  // log2 of the bins per octave
constexpr std::int32_t octaves_below = 40;
constexpr std::int32_t last_bin = bin_count - 1;

double lower_edge(std::int32_t leading) {
  return std::bit_cast<double>(static_cast<std::uint64_t>(leading) << bin_shift);
}

/// Its intersection with the span of a histogram.
Histogram::Usual within_span(const Histogram::Usual& usual, std::int32_t lowest) {
  const std::int32_t first = std::clamp(usual.first, lowest, lowest + last_bin),
                     end = std::clamp(usual.first + usual.count, first, lowest + last_bin);
  return {first, end - first};
}

/// Values below the span are counted in its lowest bin, if that is counted.
CountedBins within_span(CountedBins counted, std::int32_t lowest) {
  if (counted.begin <= lowest) {
    counted.begin = CountedBins::first;
    counted.end = std::max(counted.end, lowest + 1);
  }
  if (counted.top <= lowest) counted.top = CountedBins::first;
  return counted;
}

}  // namespace

Histogram::Histogram(std::int32_t lowest, const CountedBins& counted, const Usual& usual)
    : lowest_(lowest),
      counted_(within_span(counted, lowest)),
      usual_(within_span(usual, lowest)),
      few_(usual_.count) {}

std::int32_t Histogram::lowest_bin(std::int32_t typical) {
  constexpr std::int32_t of_one = 1023, largest = of_one + 900;
  std::int32_t exponent = typical >> octave;
  if (exponent <= 0 || exponent > largest) exponent = of_one;
  return std::max(exponent - octaves_below, 0) << octave;
}

void Histogram::add(double value) {
  const std::int32_t bin = leading_bits(value);
  const bool listed = counted_(bin), lower = !listed && bin < counted_.begin;
  add(&bin, listed, lower, !listed && !lower);
}

void Histogram::add(const std::int32_t* bins, std::size_t count, std::uint64_t below, std::uint64_t between) {
  std::uint64_t* const counters = few_.data();
  const Usual usual = usual_;  // hoisted: the counters may alias it
  for (std::size_t i = 0; i < count; ++i) {
    const auto bin = static_cast<std::uint32_t>(bins[i] - usual.first);
    if (bin < static_cast<std::uint32_t>(usual.count)) [[likely]]
      ++counters[bin];
    else
      add_unusual(bins[i]);
  }
  below_ += below;
  between_ += between;
}

void Histogram::append(const Histogram& other) {
  many_.resize(bin_count);
  for (std::size_t b = 0; b < bin_count; ++b) many_[b] += other.count_of(b);
  below_ += other.below_;
  between_ += other.between_;
}

bool Histogram::counts(std::uint64_t rank) const {
  if (rank < below_) return false;
  const std::uint64_t middle = below_ + in_the_middle();
  return rank < middle || rank >= middle + between_;
}

double Histogram::order_statistic(std::uint64_t rank, double min, double max) const {
  std::uint64_t before = below_;
  const std::size_t top = index(std::max(counted_.top, counted_.end));
  for (std::size_t b = index(std::max(leading_bits(min), counted_.begin)); b < bin_count; ++b) {
    if (b == top) before += between_;
    const std::uint64_t in_bin = count_of(b);
    if (before + in_bin <= rank) {
      before += in_bin;
      continue;
    }
    if (b == 0) return min;
    if (b + 1 == bin_count) return max;
    const std::int32_t leading = lowest_ + static_cast<std::int32_t>(b);
    const double low = std::max(lower_edge(leading), min), high = std::min(lower_edge(leading + 1), max);
    return low + (high - low) * (static_cast<double>(rank - before) + 0.5) / static_cast<double>(in_bin);
  }
  return max;
}

std::size_t Histogram::index(std::int32_t leading) const {
  return std::clamp(leading - lowest_, 0, last_bin);
}

std::uint64_t Histogram::in_the_middle() const {
  std::uint64_t sum = 0;
  for (std::size_t b = index(counted_.begin); b < index(counted_.end); ++b) sum += count_of(b);
  return sum;
}

std::uint64_t Histogram::count_of(std::size_t bin) const {
  const std::int64_t of_usual = lowest_ + static_cast<std::int64_t>(bin) - usual_.first;
  const bool usual = of_usual >= 0 && of_usual < usual_.count;
  return (usual ? few_[of_usual] : 0) + (many_.empty() ? 0 : many_[bin]);
}

void Histogram::add_unusual(std::int32_t leading) {
  many_.resize(bin_count);
  ++many_[index(leading)];
}

}  // namespace qerr
