#include "run_statistics.hpp"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>

namespace qerr {

namespace {

constexpr std::size_t most_blocks = 512;

}  // namespace

RunStatistics::RunStatistics(Eigen::Index channels, Eigen::Index expected, std::uint64_t blocks)
    : blocks_(blocks, Sums{0, Eigen::ArrayXd::Zero(channels), Eigen::ArrayXd::Zero(channels),
                           Eigen::ArrayXd::Zero(expected)}),
      peak_(Eigen::ArrayXd::Zero(expected)) {}

void RunStatistics::add(const double* values, std::size_t stride, std::size_t rows, std::size_t width,
                        std::uint64_t block, const SimulationKernels& kernels, double* room) {
  const ChannelTally tally{room, room + width, room + 2 * width, room + 3 * width};
  const Eigen::Index peaks = peak_.size();
  kernels.tally(values, stride, rows, width, static_cast<std::size_t>(peaks), tally);
  const auto n = static_cast<double>(rows);
  Sums& s = blocks_[block];
  const auto of = [&](const double* numbers) {
    return Eigen::Map<const Eigen::ArrayXd>(numbers, s.mean.size());
  };
  const Eigen::ArrayXd off = of(tally.sum) / n;
  s.join({n, of(tally.shift) + off, of(tally.squares) - off * of(tally.sum), Eigen::ArrayXd::Zero(peaks)});
  peak_ = peak_.max(of(tally.peak).head(peaks));
}

/// Two parts of a record as one: their squares, and what their means differ by.
void RunStatistics::Sums::join(const Sums& other) {
  const double both = count + other.count;
  if (both == 0) return;
  const Eigen::ArrayXd off = other.mean - mean;
  squares += other.squares + off.square() * (count * other.count / both);
  mean += off * (other.count / both);
  expected += other.expected;
  count = both;
}

void RunStatistics::append(const RunStatistics& later) {
  // The empty one that a sum starts with has blocks without samples.
  std::erase_if(blocks_, [](const Sums& s) { return s.count == 0; });
  blocks_.insert(blocks_.end(), later.blocks_.begin(), later.blocks_.end());
  peak_ = peak_.max(later.peak_);
  while (blocks_.size() > most_blocks) join_neighbours();
}

/// Memory stays the same however many runs there are; blocks of several runs serve the interval as well.
void RunStatistics::join_neighbours() {
  for (std::size_t i = 0; 2 * i < blocks_.size(); ++i) {
    Sums joined = blocks_[2 * i];
    if (2 * i + 1 < blocks_.size()) joined.join(blocks_[2 * i + 1]);
    blocks_[i] = std::move(joined);
  }
  blocks_.resize((blocks_.size() + 1) / 2);
}

double RunStatistics::mean(Eigen::Index channel) const {
  double sum = 0, count = 0;
  for (const Sums& s : blocks_) {
    sum += s.mean[channel] * s.count;
    count += s.count;
  }
  return count > 0 ? sum / count : 0;
}

double RunStatistics::variance(Eigen::Index channel) const {
  double squares = 0, count = 0;
  const double m = mean(channel);
  for (const Sums& s : blocks_) {
    squares += s.squares[channel] + s.count * std::pow(s.mean[channel] - m, 2);
    count += s.count;
  }
  return count > 0 ? squares / count : 0;
}

RunStatistics::Interval RunStatistics::sigma_interval(Eigen::Index channel) const {
  const double m = mean(channel), pooled = variance(channel);
  double expected = 0, count = 0;
  for (const Sums& s : blocks_) {
    expected += s.expected[channel];
    count += s.count;
  }
  // An expectation without bound, as of roll and yaw at the gimbal lock, says nothing of the blocks.
  const bool shaped = expected > 0 && std::isfinite(expected);
  const double ratio = shaped ? pooled * count / expected : 0;
  double sum = 0, squares = 0, n = 0;
  for (const Sums& s : blocks_) {
    if (s.count == 0) continue;
    const double v = s.squares[channel] / s.count + std::pow(s.mean[channel] - m, 2);
    const double off = shaped ? v - ratio * s.expected[channel] / s.count : v;
    sum += off;
    squares += off * off;
    n += 1;
  }
  if (n < 2) return {0, std::numeric_limits<double>::infinity()};
  const double spread = std::sqrt(std::max(0.0, (squares - sum * sum / n) / (n - 1)) / n);
  const double t = quantile(boost::math::students_t(n - 1), 0.975);
  return {std::sqrt(std::max(0.0, pooled - t * spread)), std::sqrt(pooled + t * spread)};
}

}  // namespace qerr
