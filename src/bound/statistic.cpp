#include "qerr/bound/statistic.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace qerr {

namespace {

// Bins span 2^-128 to 2^128; what is smaller or larger (0, inf) shares the outermost bins.
constexpr int lowest_exponent = -128, highest_exponent = 128, bits_per_octave = 12;
constexpr std::size_t bin_count = std::size_t(highest_exponent - lowest_exponent) << bits_per_octave;

std::size_t bin_of(double value) {
  if (!(value >= std::ldexp(1.0, lowest_exponent))) return 0;
  if (value >= std::ldexp(1.0, highest_exponent)) return bin_count - 1;
  const auto bits = std::bit_cast<std::uint64_t>(value) >> (52 - bits_per_octave);
  return static_cast<std::size_t>(bits - (std::uint64_t(1023 + lowest_exponent) << bits_per_octave));
}

double middle_of(std::size_t bin) {
  const std::uint64_t bits = std::uint64_t(bin) + (std::uint64_t(1023 + lowest_exponent) << bits_per_octave);
  const auto half = std::uint64_t{1} << (51 - bits_per_octave);
  return std::bit_cast<double>((bits << (52 - bits_per_octave)) + half);
}

}  // namespace

Accumulator::Accumulator(std::uint64_t expected) {
  if (expected > exact_limit) bins_.resize(bin_count);
}

void Accumulator::add(double value, const Eigen::VectorXd& configuration) {
  if (count_ == 0 || value > max_) {
    max_ = value;
    at_max_ = configuration;
  }
  min_ = count_ == 0 ? value : std::min(min_, value);
  sum_ += value;
  ++count_;
  if (bins_.empty())
    values_.push_back(value);
  else
    ++bins_[bin_of(value)];
}

void Accumulator::append(const Accumulator& later) {
  if (later.count_ == 0) return;
  if (count_ == 0 || later.max_ > max_) {
    max_ = later.max_;
    at_max_ = later.at_max_;
  }
  min_ = count_ == 0 ? later.min_ : std::min(min_, later.min_);
  sum_ += later.sum_;
  count_ += later.count_;
  if (bins_.empty()) {
    values_.insert(values_.end(), later.values_.begin(), later.values_.end());
  } else {
    for (const double value : later.values_) ++bins_[bin_of(value)];
    for (std::size_t i = 0; i < later.bins_.size(); ++i) bins_[i] += later.bins_[i];
  }
}

double Accumulator::order_statistic(std::uint64_t rank) const {
  if (bins_.empty()) return values_[rank];
  std::uint64_t seen = 0;
  for (std::size_t i = 0; i < bins_.size(); ++i) {
    seen += bins_[i];
    if (seen > rank)
      return i == 0 ? min_ : i + 1 == bins_.size() ? max_ : std::clamp(middle_of(i), min_, max_);
  }
  return max_;
}

double Accumulator::percentile(double fraction) const {
  const double position = fraction * static_cast<double>(count_ - 1);
  const auto below = static_cast<std::uint64_t>(position);
  const double low = order_statistic(below);
  const double part = position - static_cast<double>(below);
  if (part == 0) return low;
  const double high = order_statistic(below + 1);
  return std::isinf(high) ? high : low + part * (high - low);
}

Statistic Accumulator::result() const {
  Statistic s;
  if (count_ == 0) return s;
  std::sort(values_.begin(), values_.end());
  s.min = min_;
  s.max = max_;
  s.mean = std::clamp(sum_ / static_cast<double>(count_), min_, max_);
  s.p50 = percentile(0.50);
  s.p95 = percentile(0.95);
  s.p99 = percentile(0.99);
  s.at_max = at_max_;
  return s;
}

}  // namespace qerr
