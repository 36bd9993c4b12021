#include <algorithm>
#include <cmath>
#include <limits>

#include "core/random.hpp"
#include "core/statistics.hpp"
#include "simulate/run.hpp"

namespace qerr {

namespace {

constexpr std::size_t most_blocks = 512, most_of_piece = 4096;

}  // namespace

RunStatistics::RunStatistics(Eigen::Index channels, Eigen::Index expected, std::size_t width,
                             std::uint64_t blocks, const SimulationKernels& kernels)
    : blocks_(blocks, Sums{0, Eigen::ArrayXd::Zero(channels), Eigen::ArrayXd::Zero(channels),
                           Eigen::ArrayXd::Zero(expected)}),
      peak_(Eigen::ArrayXd::Zero(expected)),
      width_(width),
      kernels_(&kernels) {}

void RunStatistics::add(const double* values, std::size_t stride, std::size_t rows, std::uint64_t block) {
  if (numbers_.size() == 0) {
    numbers_ = AlignedNumbers(4 * width_);
    double* const n = numbers_.data();
    tally_ = {n, n + width_, n + 2 * width_, n + 3 * width_};
  }
  if (block != block_ || count_ + rows > most_of_piece) close_piece();
  block_ = block;
  kernels_->tally(values, stride, rows, width_, peak_.size(), count_ == 0, tally_);
  count_ += rows;
}

void RunStatistics::finish() {
  close_piece();
  numbers_ = {};  // frees the memory: many runs are kept until they are joined
}

/// Adds the piece to its block and clears it.
void RunStatistics::close_piece() {
  if (count_ == 0) return;
  Sums& s = blocks_[block_];
  const auto n = static_cast<double>(count_);
  for (Eigen::Index c = 0; c < s.mean.size(); ++c) {
    const double sum = tally_.sum[c];
    s.join(n, c, tally_.shift[c] + sum / n, std::max(tally_.squares[c] - sum * sum / n, 0.0));
    if (c < peak_.size()) peak_[c] = std::max(peak_[c], tally_.peak[c]);
  }
  s.count += n;
  std::fill_n(numbers_.data(), numbers_.size(), 0.0);
  count_ = 0;
}

/// Joins two parts of a record (Chan, Golub, LeVeque 1983): squares add up, plus a term for the difference of
/// the means.
void RunStatistics::Sums::join(double other_count, Eigen::Index c, double other_mean, double other_squares) {
  const double both = count + other_count, difference = other_mean - mean[c];
  squares[c] += other_squares + difference * difference * (count * other_count / both);
  mean[c] += difference * (other_count / both);
}

void RunStatistics::Sums::join(const Sums& other) {
  if (other.count > 0)
    for (Eigen::Index c = 0; c < mean.size(); ++c) join(other.count, c, other.mean[c], other.squares[c]);
  expected += other.expected;
  count += other.count;
}

void RunStatistics::append(const RunStatistics& later) {
  // The accumulator starts with blocks without samples.
  std::erase_if(blocks_, [](const Sums& s) { return s.count == 0; });
  blocks_.insert(blocks_.end(), later.blocks_.begin(), later.blocks_.end());
  peak_ = peak_.max(later.peak_);
  while (blocks_.size() > most_blocks) join_neighbours();
}

/// Joins pairs of blocks, so that memory does not grow with the number of runs.
void RunStatistics::join_neighbours() {
  for (std::size_t i = 0; 2 * i < blocks_.size(); ++i) {
    Sums joined = blocks_[2 * i];
    if (2 * i + 1 < blocks_.size()) joined.join(blocks_[2 * i + 1]);
    blocks_[i] = std::move(joined);
  }
  blocks_.resize((blocks_.size() + 1) / 2);
}

template <class Sum>
double RunStatistics::per_sample(Sum of_block) const {
  double sum = 0, count = 0;
  for (const Sums& s : blocks_) {
    sum += of_block(s);
    count += s.count;
  }
  return count > 0 ? sum / count : 0;
}

double RunStatistics::mean(Eigen::Index channel) const {
  return per_sample([&](const Sums& s) { return s.mean[channel] * s.count; });
}

double RunStatistics::variance(Eigen::Index channel) const {
  return per_sample([&, m = mean(channel)](const Sums& s) {
    return s.squares[channel] + s.count * std::pow(s.mean[channel] - m, 2);
  });
}

double RunStatistics::expected(Eigen::Index channel) const {
  return per_sample([&](const Sums& s) { return s.expected[channel]; });
}

RunStatistics::Interval RunStatistics::sigma_interval(Eigen::Index channel) const {
  const double m = mean(channel), pooled = variance(channel), expected = this->expected(channel);
  // An infinite expectation, as of roll and yaw at the gimbal lock, gives no weights of the blocks.
  const bool weighted = expected > 0 && std::isfinite(expected);
  const double ratio = weighted ? pooled / expected : 0;
  double sum = 0, squares = 0, n = 0;
  for (const Sums& s : blocks_) {
    if (s.count == 0) continue;
    const double v = s.squares[channel] / s.count + std::pow(s.mean[channel] - m, 2);
    const double residual = weighted ? v - ratio * s.expected[channel] / s.count : v;
    sum += residual;
    squares += residual * residual;
    n += 1;
  }
  if (n < 2) return {0, std::numeric_limits<double>::infinity()};
  const double spread = std::sqrt(std::max(0.0, (squares - sum * sum / n) / (n - 1)) / n);
  const double t = student_t_quantile(0.975, n - 1);
  return {std::sqrt(std::max(0.0, pooled - t * spread)), std::sqrt(pooled + t * spread)};
}

RunStatistics::Interval RunStatistics::sigma_interval_of(std::uint64_t runs, double variance,
                                                         Eigen::Index channel) const {
  constexpr std::uint64_t draws = 2000, stream = 0x64726177;
  std::uint64_t drawn = 0;
  // Variance over so many of the blocks, drawn with replacement.
  const auto variance_of_drawn = [&](std::uint64_t count) {
    double mean = 0, squares = 0;
    for (std::uint64_t r = 0; r < count; ++r) {
      const double place =
          unit_interval(random_bits(0, drawn++, stream)) * static_cast<double>(blocks_.size());
      const Sums& s = blocks_[static_cast<std::size_t>(place)];
      const double difference = s.mean[channel] - mean;
      mean += difference / static_cast<double>(r + 1);
      squares += s.squares[channel] / s.count + difference * (s.mean[channel] - mean);
    }
    return squares / static_cast<double>(count);
  };
  std::vector<double> errors;
  for (std::uint64_t d = 0; d < draws; ++d)
    errors.push_back(variance_of_drawn(runs) - variance_of_drawn(blocks_.size()));
  std::ranges::sort(errors);
  const auto root = [&](double part) {
    return std::sqrt(std::max(0.0, variance - errors[static_cast<std::size_t>(part * draws)]));
  };
  return {root(0.975), root(0.025)};
}

}  // namespace qerr
