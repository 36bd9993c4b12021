#include "qerr/bound/histogram.hpp"

#include <algorithm>
#include <bit>
#include <new>

namespace qerr {

namespace {

constexpr int octave = 52 - bin_shift;  // bins of one, as a power of two
constexpr std::int64_t octaves_below = 40;
constexpr std::uint64_t most_few = std::uint64_t{1} << 31;

double lower_edge(std::int64_t bits) {
  return std::bit_cast<double>(static_cast<std::uint64_t>(bits) << bin_shift);
}

}  // namespace

Histogram::Histogram(std::int64_t lowest)
    : lowest_(lowest), few_(static_cast<std::uint32_t*>(std::calloc(bin_count, sizeof(std::uint32_t)))) {
  if (!few_) throw std::bad_alloc();
}

std::int64_t Histogram::lowest_bin(double typical) {
  if (!(typical > 0) || typical > 0x1p900) typical = 1;
  const auto exponent = static_cast<std::int64_t>(std::bit_cast<std::uint64_t>(typical) >> 52);
  return std::max<std::int64_t>(exponent - octaves_below, 0) << octave;
}

std::uint32_t* Histogram::counts_for(std::size_t count) {
  if (added_ + count > most_few) spill();
  added_ += count;
  return few_.get();
}

void Histogram::add(const std::uint16_t* bins, std::size_t count) {
  std::uint32_t* const counts = counts_for(count);
  for (std::size_t i = 0; i < count; ++i) ++counts[bins[i]];
}

void Histogram::spill() {
  many_.resize(bin_count);
  for (std::size_t b = 0; b < bin_count; ++b) {
    many_[b] += few_[b];
    few_[b] = 0;
  }
  added_ = 0;
}

void Histogram::append(const Histogram& other) {
  spill();
  for (std::size_t b = 0; b < bin_count; ++b) many_[b] += other.at(b);
}

double Histogram::order_statistic(std::uint64_t rank, double min, double max) const {
  std::uint64_t before = 0;
  for (std::size_t b = bin_of(min, lowest_); b < bin_count; ++b) {
    const std::uint64_t here = at(b);
    if (before + here <= rank) {
      before += here;
      continue;
    }
    if (b == 0) return min;
    if (b + 1 == bin_count) return max;
    const auto bits = lowest_ + static_cast<std::int64_t>(b);
    const double low = std::max(lower_edge(bits), min), high = std::min(lower_edge(bits + 1), max);
    return low + (high - low) * (static_cast<double>(rank - before) + 0.5) / static_cast<double>(here);
  }
  return max;
}

}  // namespace qerr
