#include "simulate/run_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/random.hpp"
#include "core/statistics.hpp"

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

RunStatistics::Piece RunStatistics::piece(std::size_t width, std::size_t lanes) const {
  Piece p{lanes, 0, 0, AlignedNumbers((1 + 3 * lanes) * width), {}};
  double* const numbers = p.numbers.data();
  p.tally = {numbers, numbers + width, numbers + (1 + lanes) * width, numbers + (1 + 2 * lanes) * width};
  return p;
}

/// Prepares the piece for more samples. @returns whether they are its first ones
bool RunStatistics::extend(Piece& p, std::size_t count, std::uint64_t block) {
  if (p.count > 0 && (block != p.block || p.count + count > most_of_piece))
    close(p, &p == &rows_ ? gain_ : 1);
  p.block = block;
  p.count += count;
  return p.count == count;
}

void RunStatistics::add(const double* values, std::size_t stride, std::size_t rows, std::uint64_t block) {
  const Place place = place_of_rows(rows, block, 1);
  kernels_->tally(values, stride, rows, width_, peaks(), place.fresh, *place.tally);
}

RunStatistics::Place RunStatistics::place(std::size_t instants, std::uint64_t block) {
  if (instants_.numbers.size() == 0) instants_ = piece(width_, kernels_->lanes);
  const bool fresh = extend(instants_, instants, block);
  return {&instants_.tally, fresh};
}

RunStatistics::Place RunStatistics::place_of_rows(std::size_t rows, std::uint64_t block, double gain) {
  if (rows_.numbers.size() == 0) rows_ = piece(width_, 1);
  gain_ = gain;
  const bool fresh = extend(rows_, rows, block);
  return {&rows_.tally, fresh};
}

void RunStatistics::finish() {
  close(rows_, gain_);
  close(instants_, 1);
  rows_ = {};  // frees the memory: many runs are kept until they are joined
  instants_ = {};
}

/// Adds the piece to its block and clears it.
void RunStatistics::close(Piece& p, double gain) {
  if (p.count == 0) return;
  Sums& s = blocks_[p.block];
  const auto n = static_cast<double>(p.count);
  for (Eigen::Index c = 0; c < s.mean.size(); ++c) {
    const auto first = static_cast<std::size_t>(c) * p.lanes;
    double sum = 0, squares = 0, peak = 0;
    for (std::size_t i = first; i < first + p.lanes; ++i) {
      sum += p.tally.sum[i];
      squares += p.tally.squares[i];
      peak = std::max(peak, p.tally.peak[i]);
    }
    s.join(n, c, gain * (p.tally.shift[c] + sum / n), gain * gain * std::max(squares - sum * sum / n, 0.0));
    if (c < peak_.size()) peak_[c] = std::max(peak_[c], std::abs(gain) * peak);
  }
  s.count += n;
  for (std::size_t i = 0; i < p.numbers.size(); ++i) p.numbers[i] = 0;
  p.count = 0;
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

double RunStatistics::expected(Eigen::Index channel) const {
  double sum = 0, count = 0;
  for (const Sums& s : blocks_) {
    sum += s.expected[channel];
    count += s.count;
  }
  return count > 0 ? sum / count : 0;
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
  std::sort(errors.begin(), errors.end());
  const auto root = [&](double part) {
    return std::sqrt(std::max(0.0, variance - errors[static_cast<std::size_t>(part * draws)]));
  };
  return {root(0.975), root(0.025)};
}

}  // namespace qerr
