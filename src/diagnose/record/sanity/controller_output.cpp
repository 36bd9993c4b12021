#include <algorithm>
#include <cmath>
#include <vector>

#include "core/solve.hpp"
#include "diagnose/record/sanity/sanity_steps.hpp"
#include "diagnose/record/smooth_path.hpp"
#include "effect/effects/effects.hpp"
#include "kinematics/inverse_dynamics.hpp"

/// Efforts that are proportional to the control error: the controller's output, not a measured load. They are
/// no evidence of compliance.
namespace qerr::sanity {

namespace {

constexpr Eigen::Index most_loads = 1500;  ///< at which loads are computed

/// Residual of a proportional relation, relative to the effort, below which the effort is the output of a
/// proportional controller (convention).
constexpr double proportional_residual = 0.1;

/// Shares of the effort's variance that a load and a servo explain along the references.
struct EffortShares {
  double masses = -1;  ///< by the URDF's masses and a constant; negative if unknown for this joint
  double servo = 0;    ///< by the joint's own speed and acceleration, which a servo lags behind
};

/// Share of a signal's variance that a combination of columns and a constant explains.
double explained_by(const Eigen::MatrixXd& columns, const Eigen::ArrayXd& signal) {
  Eigen::MatrixXd all(columns.rows(), columns.cols() + 1);
  all << columns, Eigen::VectorXd::Ones(columns.rows());
  const Eigen::VectorXd c = least_norm_solution(all, signal.matrix());
  return 1 - std::pow(rms(signal - (all * c).array()) / standard_deviation(signal), 2);
}

EffortShares effort_shares(const Sanity& s, std::size_t joint, const Eigen::ArrayXd& effort) {
  const std::size_t joints = s.model.chain.independent.size();
  const auto time = s.log.find(LogSignal::time);
  EffortShares shares;
  if (!time || !has_masses(s.model.chain)) return shares;
  const Eigen::Index n = s.log.values.rows();
  const Eigen::ArrayXd t = s.log.values.col(*time);
  std::vector<Eigen::ArrayXd> q(joints), v(joints), a(joints);
  for (std::size_t j = 0; j < joints; ++j) {
    const auto column = s.log.find(LogSignal::reference, j);
    if (!column) return shares;
    const double step = s.log.columns[static_cast<std::size_t>(*column)].step();
    const SmoothPath path = smooth_path(t, s.log.values.col(*column), step);
    q[j] = path.position;
    v[j] = path.velocity;
    a[j] = smooth_path(t, path.velocity, 0).velocity;
  }
  const Eigen::Index stride = std::max<Eigen::Index>(1, n / most_loads), poses = n / stride;
  Eigen::ArrayXd load(poses), sampled(poses);
  Eigen::MatrixXd own(poses, 2);
  Eigen::VectorXd position(joints), velocity(joints), acceleration(joints);
  for (Eigen::Index i = 0; i < poses; ++i) {
    for (std::size_t j = 0; j < joints; ++j) {
      const auto row = static_cast<Eigen::Index>(j);
      position[row] = q[j][i * stride];
      velocity[row] = v[j][i * stride];
      acceleration[row] = a[j][i * stride];
    }
    load[i] =
        inverse_dynamics(s.model.chain, position, velocity, acceleration)[static_cast<Eigen::Index>(joint)];
    sampled[i] = effort[i * stride];
    own(i, 0) = velocity[static_cast<Eigen::Index>(joint)];
    own(i, 1) = acceleration[static_cast<Eigen::Index>(joint)];
  }
  if (standard_deviation(load) < 1e-9) return shares;
  shares.masses = explained_by(load.matrix(), sampled);
  shares.servo = explained_by(own, sampled);
  return shares;
}

void drop_effort(Sanity& s, std::size_t joint, const char* reason) {
  const auto effort = s.log.find(LogSignal::effort, joint);
  s.warnings.push_back(s.log.columns[static_cast<std::size_t>(*effort)].header + ": " + reason +
                       ": the output of the controller, not a load, and no evidence of compliance");
  drop_column(s.log, *effort);
}

}  // namespace

void check_controller_output(Sanity& s, std::size_t joint) {
  const auto column = s.log.find(LogSignal::effort, joint);
  const auto measured = measured_joint(s.log, s.log.values, s.model.transmission, joint);
  if (!column || !measured) return;
  const Eigen::ArrayXd effort = s.log.values.col(*column);
  if (standard_deviation(effort) == 0) return;
  const double ideal = ideal_sigma(s, joint);
  if (const auto command = s.log.find(LogSignal::command, joint)) {
    const Eigen::ArrayXd error = s.log.values.col(*command) - *measured;
    const Line line = fit_line(error, effort);
    if (line.residual_rms < proportional_residual * standard_deviation(effort) &&
        standard_deviation(error) > 2 * ideal)
      return drop_effort(s, joint, "proportional to command - measured");
  }
  const auto reference = s.log.find(LogSignal::reference, joint);
  if (!reference) return;
  const Eigen::ArrayXd error = *measured - s.log.values.col(*reference);
  const Line line = fit_line(effort, error);
  const double explained = std::abs(line.slope) * standard_deviation(effort);
  // The relation must exceed quantization, and leave little more than it.
  if (explained < 0.5 * ideal || line.residual_rms > 1.5 * ideal) return;
  const std::string& name = s.model.chain.independent[joint].name;
  // A measured load would leave the quantization error of the position in the residual.
  const bool exact = line.residual_rms < 0.3 * ideal;
  const EffortShares shares = exact ? EffortShares{0, 1} : effort_shares(s, joint, effort);
  // A load follows the masses better than the joint's own motion, a servo error the reverse.
  if (shares.masses > shares.servo) return;
  if (shares.masses < 0) {
    s.alternatives.push_back({std::string(compliance_effect().name),
                              std::string(controller_droop_effect().name), name,
                              "a measured load, or the same motion with another payload"});
    return;
  }
  const double tail = explained / std::max(line.residual_rms, 1e-12 * explained);
  const double p_value = std::exp(-0.5 * static_cast<double>(effort.size()) * std::log1p(tail * tail));
  const Eigen::ArrayXd droop = line.slope * effort;
  Cause found = exact_cause(s, joint, controller_droop_effect().name, {{"gain", 1 / line.slope}}, p_value,
                            rms(error), rms(error - droop));
  const double rows = static_cast<double>(effort.size()), gain = 1 / line.slope;
  const double half_width = 1.96 * std::abs(gain) * line.residual_rms / (explained * std::sqrt(rows));
  found.parameters = {{"gain", gain, gain - half_width, gain + half_width}};
  s.causes.push_back(std::move(found));
  if (exact) {
    // The reference is the set point, and the effort contains the rounding of the counts: no error remains.
    s.warnings.push_back(name +
                         ": the reference is the set point of the controller: no verdict on this joint");
    drop_column(s.log, *reference);
  } else if (auto read = recorded_counts(s, joint);
             read && ideal == sigma(s.model.transmission.encoders[joint])) {
    read->counts -= droop / s.model.transmission.encoders[joint].resolution;
    write_back(s, *read, joint);
  }
  drop_effort(s, joint, "proportional to measured - reference");
}

}  // namespace qerr::sanity
