#include "qerr/kinematics/configurations.hpp"

#include <boost/random/sobol.hpp>
#include <limits>

#include "core/random.hpp"

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

}  // namespace qerr
