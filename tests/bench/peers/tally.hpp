#pragma once

#include <bit>
#include <cmath>
#include <vector>

#include "contestant.hpp"

namespace qerr::bench {

/// Statistics in scalar code: maximum and its configuration, mean, and a histogram whose bins are the leading
/// bits of the number, 128 per octave (at most 0.8 % wide).
class Tally {
 public:
  static constexpr int figures = 12;

  Tally() : bins_(static_cast<std::size_t>(figures) * bin_count) {}

  void add(std::uint64_t configuration, const double* values) {
    for (int i = 0; i < figures; ++i) {
      const double x = values[i];
      if (x > max_[i]) max_[i] = x, at_max_[i] = configuration;
      sum_[i] += x;
      ++bins_[static_cast<std::size_t>(i) * bin_count + bin_of(x)];
    }
    ++count_;
  }

  Summaries result(const Eigen::MatrixXd& points) const {
    Summaries all;
    for (int i = 0; i < figures; ++i)
      all.push_back({max_[i], sum_[i] / static_cast<double>(count_), quantile(i, 0.5), quantile(i, 0.95),
                     quantile(i, 0.99), points.col(static_cast<Eigen::Index>(at_max_[i]))});
    return all;
  }

 private:
  // From 2^-44 to 2^20; smaller values are in the first bin, larger ones in the last.
  static constexpr int bits = 7;
  static constexpr std::uint64_t first = std::uint64_t{1023 - 44} << bits;
  static constexpr std::size_t bin_count = std::size_t{64} << bits;

  static std::size_t bin_of(double x) {
    const std::uint64_t leading = std::bit_cast<std::uint64_t>(x) >> (52 - bits);
    return leading < first ? 0 : std::min<std::size_t>(leading - first, bin_count - 1);
  }

  double quantile(int figure, double fraction) const {
    const auto* bins = &bins_[static_cast<std::size_t>(figure) * bin_count];
    double rest = fraction * static_cast<double>(count_);
    std::size_t b = 0;
    while (b + 1 < bin_count && rest > bins[b]) rest -= bins[b++];
    const auto edge = [](std::size_t bin) { return std::bit_cast<double>((bin + first) << (52 - bits)); };
    if (b == 0 || bins[b] == 0) return 0;
    return edge(b) + rest / bins[b] * (edge(b + 1) - edge(b));
  }

  std::array<double, figures> max_{}, sum_{};
  std::array<std::uint64_t, figures> at_max_{};
  std::uint64_t count_ = 0;
  std::vector<std::uint32_t> bins_;
};

}  // namespace qerr::bench
