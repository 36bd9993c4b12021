#include "diagnose/plan/planned_record.hpp"

#include <algorithm>
#include <cmath>

#include "diagnose/record/smooth_path.hpp"
#include "diagnose/record/with_effects.hpp"
#include "kinematics/inverse_dynamics.hpp"
#include "simulate/motion_path.hpp"

namespace qerr {

namespace {

/// Encoder coordinates, their velocities and the joints' efforts at every row.
struct SampledMotion {
  Eigen::ArrayXd time;
  Eigen::MatrixXd position, velocity, effort;  ///< encoders x rows; effort empty if unknown
  double samples_per_row = 1;
};

SampledMotion sampled(const OperationalModel& model, const Motion& motion, Eigen::Index most_rows) {
  const MotionPath path(motion);
  const double samples = std::max(1.0, std::floor(motion.duration * motion.sample_rate + 0.5));
  SampledMotion c;
  c.samples_per_row = std::ceil(samples / static_cast<double>(most_rows));
  const auto rows = static_cast<Eigen::Index>(std::ceil(samples / c.samples_per_row));
  const auto n = static_cast<Eigen::Index>(path.joints());
  const bool masses = has_masses(model.chain);
  c.time.resize(rows);
  c.position.resize(n, rows);
  c.velocity.resize(n, rows);
  if (masses) c.effort.resize(n, rows);
  Eigen::VectorXd acceleration(n);
  for (Eigen::Index k = 0; k < rows; ++k) {
    c.time[k] = static_cast<double>(k) * c.samples_per_row / motion.sample_rate;
    for (Eigen::Index j = 0; j < n; ++j) {
      const JointState state = path.at(static_cast<std::size_t>(j), c.time[k]);
      c.position(j, k) = state.position;
      c.velocity(j, k) = state.velocity;
      acceleration[j] = state.acceleration;
    }
    if (masses)
      c.effort.col(k) = inverse_dynamics(model.chain, c.position.col(k), c.velocity.col(k), acceleration);
  }
  const Coupling to_encoders = model.transmission.coupling.inverse();
  c.position = to_encoders * c.position;
  c.velocity = to_encoders * c.velocity;
  return c;
}

/// Independent readings per row: samples that are farther apart than the noise of the reference.
Eigen::ArrayXd weights(const Evidence& e, double samples_per_row) {
  Eigen::ArrayXd w = Eigen::ArrayXd::Ones(e.rows());
  const double distinct = std::max(e.noise, 0.05 * e.step());
  for (Eigen::Index k = 0; k + 1 < e.rows(); ++k)
    w[k] = std::clamp(std::abs(e.path[k + 1] - e.path[k]) / distinct, 1.0, samples_per_row);
  return w;
}

}  // namespace

std::vector<PlannedRecord> planned_records(const OperationalModel& model, const std::vector<Effect>& present,
                                           const Motion& motion, double noise, Eigen::Index most_rows) {
  const SampledMotion c = sampled(model, motion, most_rows);
  std::vector<PlannedRecord> records;
  for (std::size_t i = 0; i < model.chain.independent.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    Evidence e;
    e.joint = model.chain.independent[i].name;
    e.number = row;
    e.prismatic = model.chain.independent[i].prismatic();
    e.encoder = model.transmission.encoders[i];
    e.time = c.time;
    e.path = e.reference = c.position.row(row).transpose().array();
    e.velocity = c.velocity.row(row).transpose().array();
    e.noise = noise * e.step();
    e.path_noise = e.noise;
    e.direction = direction_of_motion(e.path, std::max(10 * e.noise, 0.1 * e.step()));
    if (c.effort.size() > 0) e.effort = c.effort.row(row).transpose().array();
    e = with_effects(std::move(e), present);
    e.measured = e.path.unaryExpr([&](double x) { return quantize(e.encoder, x); });
    e = group_means(e, independent_rows(e, 0, e.rows()));
    const Eigen::ArrayXd weight = weights(e, c.samples_per_row);
    records.push_back({std::move(e), weight});
  }
  return records;
}

}  // namespace qerr
