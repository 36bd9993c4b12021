#include "qerr/kinematics/configurations.hpp"

#include <algorithm>
#include <boost/random/sobol.hpp>
#include <limits>

#include "core/random.hpp"
#include "kinematics/kernels.hpp"
#include "kinematics/sampler.hpp"

namespace qerr {

namespace {

static_assert(boost::random::detail::qrng_tables::sobol::max_dimension == most_sobol_joints);

double between(const Limits& range, double fraction) {
  const double value = range.lower + fraction * (range.upper - range.lower);
  return std::min(std::max(value, range.lower), range.upper);
}

double grid_fraction(std::uint64_t digit, std::uint64_t count) {
  return count == 1 ? 0.5 : static_cast<double>(digit) / static_cast<double>(count - 1);
}

/// Points of the unit cube: Sobol's sequence (Joe-Kuo directions) with a random digital shift, which
/// preserves the net property for every seed.
///
/// Boost omits the first point, the origin; without it no block of 2^k points is a net.
Eigen::MatrixXd sobol_points(const Configurations& c, std::uint64_t first, std::uint64_t count) {
  const std::size_t dimensions = c.ranges.size();
  boost::random::sobol engine(dimensions);
  if (first > 1) engine.discard((first - 1) * dimensions);
  Eigen::MatrixXd unit(dimensions, count);
  for (Eigen::Index i = 0; i < unit.cols(); ++i)
    for (Eigen::Index j = 0; j < unit.rows(); ++j) {
      const bool origin = first == 0 && i == 0;
      const std::uint64_t shift = random_bits(c.seed, 0, static_cast<std::uint64_t>(j));
      unit(j, i) = unit_interval((origin ? 0 : engine()) ^ shift);
    }
  return unit;
}

Eigen::MatrixXd random_points(const Configurations& c, std::uint64_t first, std::uint64_t count) {
  Eigen::MatrixXd unit(std::ssize(c.ranges), count);
  for (Eigen::Index i = 0; i < unit.cols(); ++i)
    for (Eigen::Index j = 0; j < unit.rows(); ++j)
      unit(j, i) = unit_interval(
          random_bits(c.seed, first + static_cast<std::uint64_t>(i), static_cast<std::uint64_t>(j)));
  return unit;
}

Eigen::MatrixXd grid_points(const Configurations& c, std::uint64_t first, std::uint64_t count) {
  Eigen::MatrixXd unit(std::ssize(c.ranges), count);
  for (Eigen::Index i = 0; i < unit.cols(); ++i) {
    std::uint64_t index = first + static_cast<std::uint64_t>(i);
    for (Eigen::Index j = unit.rows(); j-- > 0; index /= c.count)
      unit(j, i) = grid_fraction(index % c.count, c.count);
  }
  return unit;
}

}  // namespace

double grid_value(const Limits& range, std::uint64_t digit, std::uint64_t count) {
  return between(range, grid_fraction(digit, count));
}

std::uint64_t size(const Configurations& c) {
  if (c.method == SamplingMethod::list) return c.points.size();
  if (c.method != SamplingMethod::grid) return c.count;
  constexpr std::uint64_t largest = std::numeric_limits<std::int64_t>::max();
  std::uint64_t total = 1;
  for (std::size_t j = 0; j < c.ranges.size(); ++j) {
    if (c.count > largest / total) return largest;
    total *= c.count;
  }
  return total;
}

Eigen::MatrixXd draw(const Configurations& c, std::uint64_t first, std::uint64_t count) {
  Eigen::MatrixXd q;
  switch (c.method) {
    case SamplingMethod::list: {
      q.resize(std::ssize(c.ranges), count);
      for (std::uint64_t i = 0; i < count; ++i) q.col(i) = c.points[first + i];
      return q;
    }
    case SamplingMethod::sobol:
      q = sobol_points(c, first, count);
      break;
    case SamplingMethod::random:
      q = random_points(c, first, count);
      break;
    case SamplingMethod::grid:
      q = grid_points(c, first, count);
      break;
  }
  for (Eigen::Index i = 0; i < q.cols(); ++i)
    for (Eigen::Index j = 0; j < q.rows(); ++j) q(j, i) = between(c.ranges[j], q(j, i));
  return q;
}

double reach(const Chain& chain, const Configurations& configurations) {
  double sum = chain.tip_offset.translation().norm();
  for (const ChainJoint& joint : chain.joints) {
    sum += joint.origin.translation().norm();
    if (!joint.prismatic) continue;
    double farthest = 0;
    const auto include = [&](double q) {
      farthest = std::max(farthest, std::abs(joint.multiplier * q + joint.offset));
    };
    if (configurations.method == SamplingMethod::list)
      for (const Eigen::VectorXd& q : configurations.points) include(q[joint.coordinate]);
    else
      for (const double q :
           {configurations.ranges[joint.coordinate].lower, configurations.ranges[joint.coordinate].upper})
        include(q);
    sum += farthest;
  }
  return sum;
}

namespace {

constexpr std::size_t bits = 64;
constexpr int unused = 11;  ///< low bits of a point: a double holds 53
constexpr std::uint64_t batches_per_block = 64, block_size = batches_per_block * batch_size;

/// [joint][b]: direction number of bit b of the Gray code of the index. Point 2^b has the Gray code
/// 2^b + 2^(b-1).
std::vector<std::uint64_t> sobol_directions(std::size_t joints, std::uint64_t count) {
  std::vector<std::uint64_t> directions(joints * bits);
  for (std::size_t b = 0; b < 63 && (b == 0 || count >> (b - 1)) && (b < 6 || count >> b); ++b) {
    boost::random::sobol engine(joints);
    const std::uint64_t before = (std::uint64_t{1} << b) - 1;  // Boost omits the first point, the origin
    if (before > 0) engine.discard(before * joints);
    for (std::size_t j = 0; j < joints; ++j)
      directions[j * bits + b] = engine() ^ (b > 0 ? directions[j * bits + b - 1] : 0);
  }
  return directions;
}

std::uint64_t sobol_point(const std::uint64_t* directions, std::uint64_t index) {
  std::uint64_t point = 0;
  for (std::uint64_t gray = index ^ (index >> 1); gray != 0; gray &= gray - 1)
    point ^= directions[__builtin_ctzll(gray)];
  return point;
}

}  // namespace

Sampler::Sampler(const Configurations& c, InstructionSet set) : configurations_(&c), set_(set) {
  for (const Limits& range : c.ranges) {
    lower_.push_back(range.lower);
    width_.push_back(range.upper - range.lower);
    upper_.push_back(range.upper);
  }
  const std::size_t joints = c.ranges.size();
  if (c.method == SamplingMethod::sobol) {
    directions_ = sobol_directions(joints, std::max(c.count, block_size) + block_size);
    for (std::size_t j = 0; j < joints; ++j) {
      keys_.push_back(random_bits(c.seed, 0, j));
      const std::uint64_t* const directions = directions_.data() + j * bits;
      for (std::uint64_t i = 0; i < batch_size; ++i)
        patterns_.push_back(sobol_point(directions, i) >> unused);
      for (std::uint64_t b = 0; b < batches_per_block; ++b)
        steps_.push_back(sobol_point(directions, b * batch_size));
    }
    block_points_.resize(joints);
    start_.resize(joints);
  } else if (c.method == SamplingMethod::random) {
    for (std::size_t j = 0; j < joints; ++j) keys_.push_back(random_key(c.seed, j));
  }
}

/// First point of a batch. gray(first + i) = gray(first) xor gray(i) if first is a multiple of a power of two
/// > i.
void Sampler::sobol(std::uint64_t first) {
  const std::uint64_t block = first / block_size, batch = first % block_size / batch_size;
  if (block != block_) {
    block_ = block;
    for (std::size_t j = 0; j < keys_.size(); ++j)
      block_points_[j] = keys_[j] ^ sobol_point(directions_.data() + j * bits, block * block_size);
  }
  for (std::size_t j = 0; j < keys_.size(); ++j)
    start_[j] = (block_points_[j] ^ steps_[j * batches_per_block + batch]) >> unused;
}

void Sampler::operator()(std::uint64_t first, double* to) {
  const SampledRanges ranges{lower_.size(), lower_.data(), width_.data(), upper_.data()};
  switch (configurations_->method) {
    case SamplingMethod::sobol:
      sobol(first);
      return select_kernels<KinematicKernels>(set_).sobol(ranges, start_.data(), patterns_.data(), to);
    case SamplingMethod::random:
      return select_kernels<KinematicKernels>(set_).random(ranges, keys_.data(), first, to);
    case SamplingMethod::grid:
      return grid(first, to);
    case SamplingMethod::list:
      for (std::size_t i = 0; i < batch_size; ++i) {
        const std::size_t point = std::min<std::size_t>(first + i, configurations_->points.size() - 1);
        for (std::size_t j = 0; j < lower_.size(); ++j)
          to[j * batch_size + i] = configurations_->points[point][j];
      }
  }
}

/// Divides for the first point of the batch only, then counts the digits up.
void Sampler::grid(std::uint64_t first, double* to) const {
  const std::uint64_t count = configurations_->count;
  std::vector<std::uint64_t> digits(lower_.size());
  for (std::size_t j = digits.size(); j-- > 0; first /= count) digits[j] = first % count;
  for (std::size_t i = 0; i < batch_size; ++i) {
    for (std::size_t j = 0; j < digits.size(); ++j)
      to[j * batch_size + i] = grid_value(configurations_->ranges[j], digits[j], count);
    for (std::size_t j = digits.size(); j-- > 0;) {
      if (++digits[j] < count) break;
      digits[j] = 0;
    }
  }
}

}  // namespace qerr
