#include "simulate/usage.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "kinematics/inverse_dynamics.hpp"
#include "simulate/motion_path.hpp"

namespace qerr {

namespace {

constexpr double most_usage_samples = 1e5, most_efforts = 1e4;

/// Evenly spaced instants of the motion: its samples if there are at most `most` of them.
std::vector<double> instants(const Motion& motion, double most) {
  const double samples = std::max(1.0, std::floor(motion.duration * motion.sample_rate + 0.5));
  const double count = std::min(samples, most);
  std::vector<double> times;
  for (double k = 0; k < count; ++k) times.push_back(k * samples / count / motion.sample_rate);
  return times;
}

using Rows = std::vector<std::vector<double>>;

void append(Rows& rows, const Eigen::VectorXd& values) {
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i].push_back(values[static_cast<Eigen::Index>(i)]);
}

void widen(Spread& s, double by) {
  s.lower -= by;
  s.upper += by;
}

/// Widens the ranges by a bound on peaks between the instants: for the position, step/4 times the largest
/// change of velocity per step; for the velocity, half of its largest second difference.
void widen_between_samples(Usage& u, const std::vector<double>& velocity, double step) {
  double change = 0, curvature = 0;
  for (std::size_t k = 1; k < velocity.size(); ++k) {
    change = std::max(change, std::abs(velocity[k] - velocity[k - 1]));
    if (k > 1) curvature = std::max(curvature, std::abs(velocity[k] - 2 * velocity[k - 1] + velocity[k - 2]));
  }
  widen(*u.position, 0.25 * change * step);
  widen(*u.velocity, 0.5 * curvature);
}

/// Position and velocity of every coordinate at the instants.
struct Path {
  Rows position, velocity;
  explicit Path(std::size_t count) : position(count), velocity(count) {}
};

/// The range of all values, and the means of those after the settling.
Spread spread_in(const Motion& motion, const std::vector<double>& values) {
  const double settling = motion.settling.value_or(0) / motion.duration;
  const auto first = static_cast<std::size_t>(settling * static_cast<double>(values.size()));
  Spread all = spread_of(values);
  const Spread counted = spread_of(std::span(values).subspan(std::min(first, values.size() - 1)));
  all.mean = counted.mean;
  all.mean_square = counted.mean_square;
  return all;
}

std::vector<Usage> usages(const Path& path, const Motion& motion) {
  std::vector<Usage> all;
  for (std::size_t i = 0; i < path.position.size(); ++i) {
    Usage& u = all.emplace_back();
    u.position = spread_in(motion, path.position[i]);
    u.velocity = spread_in(motion, path.velocity[i]);
    widen_between_samples(u, path.velocity[i],
                          motion.duration / static_cast<double>(path.position[i].size()));
    u.duration = motion.duration;
  }
  return all;
}

void include(Spread& s, double value) {
  s.lower = std::min(s.lower, value);
  s.upper = std::max(s.upper, value);
}

/// Extends the ranges to `margin` before and after the motion; means stay those of the motion.
void include_margin(const MotionPath& path, const Motion& motion, double margin, const Coupling& to_encoders,
                    RobotUsage& usage) {
  constexpr int steps = 512;
  for (int k = 1; k <= steps; ++k) {
    const double beyond = margin * k / steps;
    for (const double t : {-beyond, motion.duration + beyond}) {
      const Eigen::VectorXd q = path.position(t), v = path.velocity(t);
      const Eigen::VectorXd x = to_encoders * q, u = to_encoders * v;
      for (Eigen::Index i = 0; i < q.size(); ++i) {
        const auto row = static_cast<std::size_t>(i);
        include(*usage.joints[row].position, q[i]);
        include(*usage.joints[row].velocity, v[i]);
        include(*usage.encoders[row].position, x[i]);
        include(*usage.encoders[row].velocity, u[i]);
      }
    }
  }
}

/// Widens the positions by half a count: the zero of an encoder is anywhere in a count.
void include_zeros(const Transmission& transmission, RobotUsage& usage) {
  const Eigen::VectorXd encoders = 0.5 * resolutions(transmission),
                        joints = transmission.coupling.magnitudes() * encoders;
  for (std::size_t i = 0; i < usage.joints.size(); ++i) {
    widen(*usage.joints[i].position, joints[static_cast<Eigen::Index>(i)]);
    widen(*usage.encoders[i].position, encoders[static_cast<Eigen::Index>(i)]);
  }
}

void add_efforts(const Chain& chain, const MotionPath& path, const Motion& motion,
                 std::vector<Usage>& joints) {
  Rows efforts(joints.size());
  for (const double t : instants(motion, most_efforts))
    append(efforts, inverse_dynamics(chain, path.position(t), path.velocity(t), path.acceleration(t)));
  for (std::size_t i = 0; i < joints.size(); ++i) joints[i].effort = spread_in(motion, efforts[i]);
}

}  // namespace

RobotUsage usage_in_motion(const OperationalModel& model, const Motion& motion, double margin) {
  const MotionPath path(motion);
  const Coupling to_encoders = model.transmission.coupling.inverse();
  Path joints(path.joints()), encoders(path.joints());
  for (const double t : instants(motion, most_usage_samples)) {
    const Eigen::VectorXd q = path.position(t), v = path.velocity(t);
    append(joints.position, q);
    append(joints.velocity, v);
    append(encoders.position, to_encoders * q);
    append(encoders.velocity, to_encoders * v);
  }
  RobotUsage usage{usages(joints, motion), usages(encoders, motion)};
  if (margin > 0) include_margin(path, motion, margin, to_encoders, usage);
  include_zeros(model.transmission, usage);
  if (has_masses(model.chain)) add_efforts(model.chain, path, motion, usage.joints);
  return usage;
}

}  // namespace qerr
