#include "qerr/bound/histogram.hpp"

#include <algorithm>
#include <bit>
#include <new>

namespace qerr {

namespace {

constexpr int octave = 52 - bin_shift;  // bins of one, as a power of two
constexpr std::int32_t octaves_below = 40;
constexpr std::uint32_t last_bin = bin_count - 1;
constexpr std::uint64_t most_few = std::uint64_t{1} << 31;

double lower_edge(std::int32_t leading) {
  return std::bit_cast<double>(static_cast<std::uint64_t>(leading) << bin_shift);
}

}  // namespace

Histogram::Histogram(std::int32_t lowest, const CountedBins& counted)
    : lowest_(lowest),
      counted_(counted),
      few_(static_cast<Counters*>(std::calloc(bin_count, sizeof(Counters)))) {
  if (!few_) throw std::bad_alloc();
}

std::int32_t Histogram::lowest_bin(double typical) {
  if (!(typical > 0) || typical > 0x1p900) typical = 1;
  const auto exponent = static_cast<std::int32_t>(std::bit_cast<std::uint64_t>(typical) >> 52);
  return std::max(exponent - octaves_below, 0) << octave;
}

void Histogram::add(double value) {
  const std::int32_t bin = leading_bits(value);
  const bool listed = counted_(bin), lower = !listed && bin < counted_.begin;
  add(&bin, listed, lower, !listed && !lower);
}

void Histogram::add(const std::int32_t* bins, std::size_t count, std::uint64_t below, std::uint64_t between) {
  if (added_ + count > most_few) spill();
  added_ += count;
  Counters* const counters = few_.get();
  const std::int32_t lowest = lowest_;  // which the compiler would read again for every bin
  const auto count_one = [&](std::size_t i) {
    auto bin = static_cast<std::uint32_t>(bins[i] - lowest);
    if (bin > last_bin) [[unlikely]]
      bin = bins[i] < lowest ? 0 : last_bin;
    ++counters[bin].in_turn[i % copies];
  };
  std::size_t i = 0;
  for (; i + copies <= count; i += copies)
    for (std::size_t k = 0; k < copies; ++k) count_one(i + k);
  for (; i < count; ++i) count_one(i);
  below_ += below;
  between_ += between;
}

void Histogram::append(const Histogram& other) {
  spill();
  for (std::size_t b = 0; b < bin_count; ++b) many_[b] += other.at(b);
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
    const std::uint64_t here = at(b);
    if (before + here <= rank) {
      before += here;
      continue;
    }
    if (b == 0) return min;
    if (b + 1 == bin_count) return max;
    const std::int32_t leading = lowest_ + static_cast<std::int32_t>(b);
    const double low = std::max(lower_edge(leading), min), high = std::min(lower_edge(leading + 1), max);
    return low + (high - low) * (static_cast<double>(rank - before) + 0.5) / static_cast<double>(here);
  }
  return max;
}

std::size_t Histogram::index(std::int32_t leading) const {
  return static_cast<std::size_t>(std::clamp(leading - lowest_, 0, static_cast<std::int32_t>(last_bin)));
}

std::uint64_t Histogram::in_the_middle() const {
  std::uint64_t sum = 0;
  for (std::size_t b = index(counted_.begin); b < index(counted_.end); ++b) sum += at(b);
  return sum;
}

void Histogram::spill() {
  many_.resize(bin_count);
  for (std::size_t b = 0; b < bin_count; ++b) {
    many_[b] += few_[b].sum();
    few_[b] = {};
  }
  added_ = 0;
}

}  // namespace qerr
