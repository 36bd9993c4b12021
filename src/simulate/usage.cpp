#include "qerr/simulate/usage.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "qerr/kinematics/inverse_dynamics.hpp"

namespace qerr {

namespace {

constexpr double most_samples = 1e5, most_efforts = 1e4, most_speeds = 1024;

/// Instants spread evenly over the motion, samples of it where it has no more than `most`.
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

/// Velocities at middles of equal parts of the motion.
std::vector<double> thinned(const std::vector<double>& values) {
  const double count = std::min(most_speeds, static_cast<double>(values.size()));
  std::vector<double> few;
  for (double k = 0; k < count; ++k)
    few.push_back(values[static_cast<std::size_t>((k + 0.5) * static_cast<double>(values.size()) / count)]);
  return few;
}

void widen(Spread& s, double by) {
  s.lower -= by;
  s.upper += by;
}

/// Peaks lie between the instants: of a position with bounded acceleration by at most a quarter of a step's
/// change of velocity times the step, of a velocity that bends by half of the largest second difference.
void reach_between(Usage& u, const std::vector<double>& velocity, double step) {
  double change = 0, bend = 0;
  for (std::size_t k = 1; k < velocity.size(); ++k) {
    change = std::max(change, std::abs(velocity[k] - velocity[k - 1]));
    if (k > 1) bend = std::max(bend, std::abs(velocity[k] - 2 * velocity[k - 1] + velocity[k - 2]));
  }
  widen(*u.position, 0.25 * change * step);
  widen(*u.velocity, 0.5 * bend);
}

std::vector<Usage> usages(const Rows& positions, const Rows& velocities, const Motion& motion) {
  std::vector<Usage> all;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    Usage& u = all.emplace_back();
    u.position = spread_of(positions[i]);
    u.velocity = spread_of(velocities[i]);
    reach_between(u, velocities[i], motion.duration / static_cast<double>(positions[i].size()));
    u.duration = motion.duration;
    u.speeds = thinned(velocities[i]);
  }
  return all;
}

void add_efforts(const Chain& chain, const MotionPath& path, const Motion& motion,
                 std::vector<Usage>& joints) {
  Rows efforts(joints.size());
  // Half a sample to either side: steps of the acceleration at the ends of moves are met by their mean.
  const double step = 0.5 / motion.sample_rate;
  for (const double t : instants(motion, most_efforts)) {
    const Eigen::VectorXd acceleration = (path.velocity(t + step) - path.velocity(t - step)) / (2 * step);
    append(efforts, inverse_dynamics(chain, path.position(t), path.velocity(t), acceleration));
  }
  for (std::size_t i = 0; i < joints.size(); ++i) joints[i].effort = spread_of(efforts[i]);
}

}  // namespace

RobotUsage usage_in_motion(const OperationalModel& model, const Motion& motion) {
  const MotionPath path(motion);
  const Eigen::MatrixXd to_encoders = model.transmission.coupling.inverse();
  Rows q(path.joints()), v(path.joints()), encoder_q(path.joints()), encoder_v(path.joints());
  for (const double t : instants(motion, most_samples)) {
    const Eigen::VectorXd position = path.position(t), velocity = path.velocity(t);
    append(q, position);
    append(v, velocity);
    append(encoder_q, to_encoders * position);
    append(encoder_v, to_encoders * velocity);
  }
  RobotUsage usage{usages(q, v, motion), usages(encoder_q, encoder_v, motion)};
  if (has_masses(model.chain)) add_efforts(model.chain, path, motion, usage.joints);
  return usage;
}

}  // namespace qerr
