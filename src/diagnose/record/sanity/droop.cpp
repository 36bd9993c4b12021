#include <algorithm>
#include <cmath>
#include <vector>

#include "diagnose/record/sanity/sanity_steps.hpp"
#include "diagnose/record/smooth_path.hpp"
#include "kinematics/inverse_dynamics.hpp"

/// Efforts that are no loads: a controller's output follows its own error, and shows no compliance.
namespace qerr::sanity {

namespace {

constexpr Eigen::Index most_poses = 1500;

/// Share of the effort's variance that the URDF's masses explain (with a constant) along the references, or
/// a negative number where they say nothing about this joint.
double share_of_load(const Sanity& s, std::size_t joint, const Eigen::ArrayXd& effort) {
  const std::size_t joints = s.model.chain.independent.size();
  const auto time = s.log.find(LogSignal::time);
  if (!time || !has_masses(s.model.chain)) return -1;
  const Eigen::Index n = s.log.values.rows();
  const Eigen::ArrayXd t = s.log.values.col(*time);
  std::vector<Eigen::ArrayXd> q(joints), v(joints), a(joints);
  for (std::size_t j = 0; j < joints; ++j) {
    const auto column = s.log.find(LogSignal::reference, j);
    if (!column) return -1;
    const double grid = s.log.columns[static_cast<std::size_t>(*column)].step();
    const SmoothPath path = smooth_path(t, s.log.values.col(*column), grid);
    q[j] = path.position;
    v[j] = path.velocity;
    a[j] = smooth_path(t, path.velocity, 0).velocity;
  }
  const Eigen::Index stride = std::max<Eigen::Index>(1, n / most_poses), poses = n / stride;
  Eigen::ArrayXd load(poses), sampled(poses);
  Eigen::VectorXd at(joints), velocity(joints), acceleration(joints);
  for (Eigen::Index i = 0; i < poses; ++i) {
    for (std::size_t j = 0; j < joints; ++j) {
      const auto row = static_cast<Eigen::Index>(j);
      at[row] = q[j][i * stride];
      velocity[row] = v[j][i * stride];
      acceleration[row] = a[j][i * stride];
    }
    load[i] = inverse_dynamics(s.model.chain, at, velocity, acceleration)[static_cast<Eigen::Index>(joint)];
    sampled[i] = effort[i * stride];
  }
  if (standard_deviation(load) < 1e-9) return -1;
  return 1 - std::pow(fit_line(load, sampled).residual_rms / standard_deviation(sampled), 2);
}

/// The effort is what a controller makes of its own error: neither a load nor, behind it, a compliance.
void drop_effort(Sanity& s, std::size_t joint, const char* why) {
  const auto effort = s.log.find(LogSignal::effort, joint);
  s.warnings.push_back(s.log.columns[static_cast<std::size_t>(*effort)].header + ": " + why +
                       ": it is the controller's output, not a load, and no evidence for compliance");
  drop_column(s.log, *effort);
}

}  // namespace

void check_droop(Sanity& s, std::size_t joint) {
  const auto column = s.log.find(LogSignal::effort, joint);
  const auto measured = measured_joint(s.log, s.log.values, s.model.transmission, joint);
  if (!column || !measured) return;
  const Eigen::ArrayXd effort = s.log.values.col(*column);
  if (standard_deviation(effort) == 0) return;
  const double ideal = ideal_sigma(s, joint);
  if (const auto command = s.log.find(LogSignal::command, joint)) {
    const Eigen::ArrayXd error = s.log.values.col(*command) - *measured;
    const Line line = fit_line(error, effort);
    if (line.residual_rms < 0.1 * standard_deviation(effort) && standard_deviation(error) > 2 * ideal)
      return drop_effort(s, joint, "a multiple of command - measured");
  }
  const auto reference = s.log.find(LogSignal::reference, joint);
  if (!reference) return;
  const Eigen::ArrayXd error = *measured - s.log.values.col(*reference);
  const Line line = fit_line(effort, error);
  const double explained = std::abs(line.slope) * standard_deviation(effort);
  if (explained < 0.5 * ideal || line.residual_rms > 1.5 * ideal) return;
  const std::string& name = s.model.chain.independent[joint].name;
  const bool exact = line.residual_rms < 0.3 * ideal;
  const double load = exact ? 0 : share_of_load(s, joint, effort);
  if (load > 0.5) return;
  if (load < 0) {
    s.alternatives.push_back({"compliance", "controller_droop", name,
                              "a load that is measured, or the same motion with another payload"});
    return;
  }
  const double tail = explained / std::max(line.residual_rms, 1e-12 * explained);
  const double chance = std::exp(-0.5 * static_cast<double>(effort.size()) * std::log1p(tail * tail));
  const Eigen::ArrayXd droop = line.slope * effort;
  Cause found =
      cause(s, joint, "controller_droop", {{"gain", 1 / line.slope}}, chance, rms(error), rms(error - droop));
  const double rows = static_cast<double>(effort.size()), gain = 1 / line.slope;
  const double wide = 1.96 * std::abs(gain) * line.residual_rms / (explained * std::sqrt(rows));
  found.parameters = {{"gain", gain, gain - wide, gain + wide}};
  s.causes.push_back(std::move(found));
  if (exact) {
    // The reference is the set point, and the effort has the counts' own rounding in it: nothing is left.
    s.warnings.push_back(name +
                         ": the reference is the set point of the controller: the joint is not judged");
    drop_column(s.log, *reference);
  } else if (auto read = readings(s, joint); read && ideal == sigma(s.model.transmission.encoders[joint])) {
    read->counts -= droop / s.model.transmission.encoders[joint].resolution;
    write_back(s, *read, joint);
  }
  drop_effort(s, joint, "a multiple of measured - reference");
}

}  // namespace qerr::sanity
