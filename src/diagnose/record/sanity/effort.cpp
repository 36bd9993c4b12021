#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "core/solve.hpp"
#include "core/text.hpp"
#include "diagnose/record/sanity/sanity_steps.hpp"
#include "diagnose/record/smooth_path.hpp"
#include "effect/effects/effects.hpp"
#include "kinematics/inverse_dynamics.hpp"

/// Efforts that are proportional to the control error are the controller's output, not a measured load, and
/// no evidence of compliance. Currents and torques of motors become loads.
namespace qerr::sanity {

namespace {

constexpr Eigen::Index most_loads = 1500;  ///< at which loads are computed

/// Residual of a proportional relation, relative to the effort, below which the effort is the output of a
/// proportional controller (convention).
constexpr double proportional_residual = 0.1;

/// A joint along its reference.
struct JointPath {
  Eigen::ArrayXd position, velocity, acceleration;
};

std::vector<Eigen::Index> all_rows(Eigen::Index count) {
  std::vector<Eigen::Index> rows(static_cast<std::size_t>(count));
  std::iota(rows.begin(), rows.end(), Eigen::Index{0});
  return rows;
}

/// A signal of some instants at others, linear between them and constant beyond.
Eigen::ArrayXd interpolated(const Eigen::ArrayXd& instants, const Eigen::ArrayXd& signal,
                            const Eigen::ArrayXd& at) {
  return at.unaryExpr([&](double t) {
    const auto next = std::upper_bound(instants.begin(), instants.end(), t) - instants.begin();
    if (next == 0 || next == instants.size()) return signal[std::max<Eigen::Index>(0, next - 1)];
    const double part = (t - instants[next - 1]) / (instants[next] - instants[next - 1]);
    return signal[next - 1] + part * (signal[next] - signal[next - 1]);
  });
}

std::optional<JointPath> joint_path(const Sanity& s, std::size_t joint) {
  const auto time = s.log.find(LogSignal::time), column = s.log.find(LogSignal::reference, joint);
  if (!time || !column) return std::nullopt;
  const Eigen::ArrayXd t = s.log.values.col(*time);
  const double step = s.log.columns[static_cast<std::size_t>(*column)].step();
  // A load needs a smooth acceleration more than an exact velocity. Between the samples of a slower reference
  // its noise is alike from row to row, and no path smooth.
  std::vector<Eigen::Index> rows = s.log.rows_at_samples(static_cast<std::size_t>(*column));
  if (rows.empty()) rows = all_rows(t.size());
  const Eigen::ArrayXd read = t(rows);
  const SmoothPath path = smooth_path(read, s.log.values.col(*column)(rows), step, true);
  const Eigen::ArrayXd acceleration =
      path.acceleration.size() > 0 ? path.acceleration : smooth_path(read, path.velocity, 0).velocity;
  if (read.size() == t.size()) return JointPath{path.position, path.velocity, acceleration};
  return JointPath{interpolated(read, path.position, t), interpolated(read, path.velocity, t),
                   interpolated(read, acceleration, t)};
}

/// Those with a reference, of all joints.
using JointPaths = std::vector<std::optional<JointPath>>;

JointPaths joint_paths(const Sanity& s) {
  JointPaths all(s.model.chain.independent.size());
  for (std::size_t j = 0; j < all.size(); ++j) all[j] = joint_path(s, j);
  return all;
}

/// Gravity's part alone: the acceleration of a path of counts is mostly that of their steps.
JointPaths paths_of_readings(const Sanity& s) {
  JointPaths all(s.model.chain.independent.size());
  for (std::size_t j = 0; j < all.size(); ++j)
    if (const auto measured = measured_joint(s.log, s.log.values, s.model.transmission, j)) {
      const Eigen::ArrayXd still = Eigen::ArrayXd::Zero(measured->size());
      all[j] = JointPath{*measured, still, still};
    }
  return all;
}

/// Loads by the URDF's masses at every `stride`-th row [N m or N].
struct Loads {
  Eigen::ArrayXd sampled;
  Eigen::Index stride = 1;

  Eigen::ArrayXd of_rows(const Eigen::ArrayXd& rows) const {
    return rows(Eigen::seqN(0, sampled.size(), stride));
  }
  /// Interpolated to all rows.
  Eigen::ArrayXd at_all(Eigen::Index rows) const {
    Eigen::ArrayXd all(rows);
    for (Eigen::Index k = 0; k < rows; ++k) {
      const Eigen::Index i = std::min(k / stride, sampled.size() - 1),
                         next = std::min(i + 1, sampled.size() - 1);
      const double part = std::min(1.0, static_cast<double>(k - i * stride) / static_cast<double>(stride));
      all[k] = sampled[i] + part * (sampled[next] - sampled[i]);
    }
    return all;
  }
};

/// Loads of all joints. Empty without masses or a path of every joint, and of a joint whose load is constant.
std::vector<std::optional<Loads>> loads_by_masses(const Sanity& s, const JointPaths& paths) {
  std::vector<std::optional<Loads>> all(paths.size());
  const bool known = std::all_of(paths.begin(), paths.end(), [](const auto& p) { return p.has_value(); });
  if (!known || !has_masses(s.model.chain)) return all;
  const Eigen::Index n = s.log.values.rows(), stride = std::max<Eigen::Index>(1, n / most_loads);
  const auto joints = static_cast<Eigen::Index>(paths.size());
  Eigen::ArrayXXd loads(n / stride, joints);
  Eigen::VectorXd position(joints), velocity(joints), acceleration(joints);
  for (Eigen::Index i = 0; i < loads.rows(); ++i) {
    for (Eigen::Index j = 0; j < joints; ++j) {
      const JointPath& p = *paths[static_cast<std::size_t>(j)];
      position[j] = p.position[i * stride];
      velocity[j] = p.velocity[i * stride];
      acceleration[j] = p.acceleration[i * stride];
    }
    loads.row(i) = inverse_dynamics(s.model.chain, position, velocity, acceleration).transpose();
  }
  for (Eigen::Index j = 0; j < joints; ++j)
    if (standard_deviation(loads.col(j)) >= 1e-9)
      all[static_cast<std::size_t>(j)] = Loads{loads.col(j), stride};
  return all;
}

/// Coefficients of columns beside a constant, and what they leave of a signal.
struct Regression {
  Eigen::VectorXd coefficients;  ///< the constant last
  double residual_rms = 0;
};

Regression regression(const Eigen::MatrixXd& columns, const Eigen::ArrayXd& signal) {
  Eigen::MatrixXd all(columns.rows(), columns.cols() + 1);
  all << columns, Eigen::VectorXd::Ones(columns.rows());
  Regression r{least_norm_solution(all, signal.matrix()), 0};
  r.residual_rms = rms(signal - (all * r.coefficients).array());
  return r;
}

/// Share of a signal's variance that a combination of columns and a constant explains.
double explained_by(const Eigen::MatrixXd& columns, const Eigen::ArrayXd& signal) {
  return 1 - std::pow(regression(columns, signal).residual_rms / standard_deviation(signal), 2);
}

/// Shares of the effort's variance that a load and a servo explain along the references.
struct EffortShares {
  double masses = -1;  ///< by the URDF's masses and a constant; negative if unknown for this joint
  double servo = 0;    ///< by the joint's own speed and acceleration, which a servo lags behind
};

EffortShares effort_shares(const Sanity& s, std::size_t joint, const Eigen::ArrayXd& effort) {
  const JointPaths paths = joint_paths(s);
  const std::optional<Loads> loads = loads_by_masses(s, paths)[joint];
  if (!loads) return {};
  const JointPath& motion = *paths[joint];
  const Eigen::ArrayXd sampled = loads->of_rows(effort);
  Eigen::MatrixXd own(sampled.size(), 2);
  own << loads->of_rows(motion.velocity).matrix(), loads->of_rows(motion.acceleration).matrix();
  return {explained_by(loads->sampled.matrix(), sampled), explained_by(own, sampled)};
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
  if (!column) return;
  const auto measured = measured_joint(s.log, s.log.values, s.model.transmission, joint);
  if (!measured) return;
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
  // A load follows the masses, a servo error the joint's own motion. The load of a balanced joint is its
  // acceleration, of which the own motion has more than the masses.
  constexpr double as_well = 0.02;
  if (shares.masses > shares.servo - as_well) return;
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

namespace {

/// Efforts that follow the masses to this share of their variance tell their unit and sign.
constexpr double follows_masses = 0.9;

/// Payloads and friction change the factor of an effort in N m by less than this.
constexpr double same_unit = 1.5;

/// A load by the masses takes the place of an effort for so much less of an error's rest (convention).
constexpr double matters = 0.9;

/// What an effort of the wrong sign leaves of the error that it causes (convention).
constexpr double opposite = 0.1;

/// Dry friction by the speed, without a jump at rest: -1 to 1.
Eigen::ArrayXd direction_by_speed(const Eigen::ArrayXd& velocity) {
  constexpr double slow = 0.02;  // of the highest speed: there the direction is uncertain
  const double ramp = slow * std::max(velocity.abs().maxCoeff(), 1e-300);
  return (velocity / ramp).max(-1.0).min(1.0);
}

/// Columns that take off an effort what a gear does not transmit, at all rows.
Eigen::MatrixXd beside_load(const JointPath& m) {
  Eigen::MatrixXd columns(m.position.size(), 3);
  columns << direction_by_speed(m.velocity).matrix(), m.velocity.matrix(), m.acceleration.matrix();
  return columns;
}

/// What an effort, less what a gear does not transmit of it, leaves of an error.
double left_by_drive(const Eigen::ArrayXd& effort, const Eigen::MatrixXd& beside,
                     const Eigen::ArrayXd& error) {
  Eigen::MatrixXd columns(effort.size(), beside.cols() + 1);
  columns << effort.matrix(), beside;
  return regression(columns, error).residual_rms;
}

/// An effort by least squares: factor load + friction by direction and speed + inertia acceleration +
/// constant.
struct EffortParts {
  double factor = 0;       ///< of the load by the URDF's masses; 0: they do not tell
  double dry = 0;          ///< friction [unit of the effort]
  Eigen::MatrixXd beside;  ///< columns that take off what the gear does not transmit: all rows x 3
};

EffortParts effort_parts(const Eigen::ArrayXd& effort, const JointPath& m, const Loads& loads) {
  EffortParts p;
  p.beside = beside_load(m);
  const Eigen::ArrayXd sampled = loads.of_rows(effort);
  Eigen::MatrixXd columns(sampled.size(), 4);
  columns << loads.sampled.matrix(), p.beside(Eigen::seqN(0, sampled.size(), loads.stride), Eigen::all);
  const Regression r = regression(columns, sampled);
  p.dry = std::abs(r.coefficients[1]);
  const double left = r.residual_rms;
  if (std::pow(left / standard_deviation(sampled), 2) < 1 - follows_masses &&
      std::abs(r.coefficients[0]) * standard_deviation(loads.sampled) > 3 * left)
    p.factor = r.coefficients[0];
  return p;
}

/// Converts an effort to N m or N, with the sign of the load. One that is stated in these keeps its size, as
/// a payload may be unknown, but at the motor's side of a gear.
void convert_effort(Sanity& s, std::size_t joint, Eigen::Index column, double factor) {
  LogColumn& head = s.log.columns[static_cast<std::size_t>(column)];
  const IndependentJoint& j = s.model.chain.independent[joint];
  const std::string unit = j.prismatic() ? "N" : "N m";
  const bool stated = head.unit == unit;
  const double ratio = std::abs(s.model.transmission.encoders[joint].shaft_ratio),
               of_motor = std::abs(factor) * ratio;
  const bool at_motor = ratio > 2 * same_unit && of_motor < same_unit && of_motor > 1 / same_unit;
  if (!stated || at_motor) {
    s.data.push_back({head.header + ": 1 " + head.unit + " is " + readable(1 / factor, unit) +
                          " by the masses of the URDF",
                      j.name,
                      {},
                      {},
                      "write the effort in " + unit + " at the joint",
                      stated ? DataKind::contradictory : DataKind::remark});
  } else if (factor < 0) {
    factor = -1;
    s.data.push_back({head.header + " has the opposite sign of the load by the masses of the URDF",
                      j.name,
                      {},
                      {},
                      "reverse the sign of the effort",
                      DataKind::contradictory});
  } else {
    return;
  }
  head.unit = unit;
  s.log.values.col(column) /= factor;
}

/// An effort without what dry friction holds at rest, which does not tell: there, and where the joint nearly
/// rests, it is what it has of weight, friction and inertia in motion. Empty where these are not all of it,
/// as on an arm whose other joints turn the weight, and where friction does not exceed what they leave.
std::optional<Eigen::ArrayXd> without_stiction(const Eigen::ArrayXd& effort, const JointPath& m) {
  constexpr double slow = 0.05, unexplained = 0.2;  // of the highest speed; of the effort (conventions)
  const Eigen::ArrayXd speed = m.velocity.abs();
  std::vector<Eigen::Index> moving, resting;
  for (Eigen::Index k = 0; k < speed.size(); ++k)
    (speed[k] > slow * speed.maxCoeff() ? moving : resting).push_back(k);
  if (static_cast<Eigen::Index>(moving.size()) < fewest_rows_of_slope) return std::nullopt;
  Eigen::MatrixXd columns(effort.size(), 6);
  columns << beside_load(m), m.position.sin().matrix(), m.position.cos().matrix(),
      Eigen::VectorXd::Ones(effort.size());
  const Eigen::VectorXd in_motion = effort(moving).matrix();
  const Eigen::VectorXd parts = least_norm_solution(columns(moving, Eigen::all), in_motion);
  const Eigen::VectorXd by_parts = columns * parts;
  const double left = rms((in_motion - by_parts(moving)).array());
  if (left > unexplained * standard_deviation(in_motion.array()) || std::abs(parts[0]) < 2 * left)
    return std::nullopt;
  Eigen::ArrayXd less = effort;
  less(resting) = by_parts(resting).array();
  return less;
}

/// Puts the load by the masses in the effort's place where it leaves less of the error than the effort
/// without what a drive needs for itself.
/// @returns whether it did
bool replace_by_masses(Sanity& s, std::size_t joint, Eigen::Index column, const EffortParts& parts,
                       const Loads& loads, const Eigen::ArrayXd& error) {
  const Eigen::ArrayXd effort = s.log.values.col(column), load = loads.at_all(effort.size());
  const double by_effort = std::min(left_by_drive(effort, parts.beside, error), standard_deviation(error));
  if (regression(load.matrix(), error).residual_rms >= matters * by_effort) return false;
  LogColumn& head = s.log.columns[static_cast<std::size_t>(column)];
  s.data.push_back({head.header + " is more than the load: friction of " + readable(parts.dry, head.unit) +
                        ", and what the rotor takes",
                    s.model.chain.independent[joint].name,
                    {},
                    {},
                    "the load by the masses of the URDF is used in its place"});
  head.unit = s.model.chain.independent[joint].prismatic() ? "N" : "N m";
  head.computed = true;
  s.log.values.col(column) = load;
  return true;
}

}  // namespace

DataFinding reverse_effort(Sanity& s, std::size_t joint) {
  const Eigen::Index column = *s.log.find(LogSignal::effort, joint);
  s.log.values.col(column) *= -1;
  return {s.log.columns[static_cast<std::size_t>(column)].header +
              " has the opposite sign of the load: a compliance would be negative",
          s.model.chain.independent[joint].name,
          {},
          {},
          "reverse the sign of the effort",
          DataKind::contradictory};
}

namespace {

void make_load(Sanity& s, std::size_t joint, const std::optional<JointPath>& motion,
               const std::optional<Loads>& loads) {
  const auto column = s.log.find(LogSignal::effort, joint);
  const auto measured = measured_joint(s.log, s.log.values, s.model.transmission, joint);
  if (!column || !motion || !measured) return;
  auto effort = s.log.values.col(*column);
  if (standard_deviation(effort) == 0) return;
  const Eigen::ArrayXd error = *measured - s.log.values.col(*s.log.find(LogSignal::reference, joint));
  LogColumn& head = s.log.columns[static_cast<std::size_t>(*column)];
  double factor = 0;
  if (loads) {
    const EffortParts parts = effort_parts(effort, *motion, *loads);
    if (replace_by_masses(s, joint, *column, parts, *loads, error)) return;
    factor = parts.factor;
  }
  // A current has noise, which would be an error of the load, and at rest what friction holds.
  constexpr double better = 0.998;  // of what the error leaves: beyond what chance makes of a thousand rows
  const Eigen::MatrixXd beside = beside_load(*motion);
  const auto replace = [&](const Eigen::ArrayXd& other) {
    if (left_by_drive(other, beside, error) < better * left_by_drive(effort, beside, error)) effort = other;
  };
  replace(smooth_path(s.log.values.col(*s.log.find(LogSignal::time)), effort, head.step(), true).position);
  if (const auto less = loads ? std::nullopt : without_stiction(effort, *motion)) replace(*less);
  if (factor != 0) convert_effort(s, joint, *column, factor);
  // Without masses only the error itself tells the sign: no load deflects a gear against itself.
  const Line of_error = fit_line(s.log.values.col(*column).array(), error);
  if (!loads && of_error.slope < 0 && of_error.residual_rms < opposite * standard_deviation(error)) {
    s.data.push_back(reverse_effort(s, joint));
  }
  const std::string force = s.model.chain.independent[joint].prismatic() ? "N" : "N m";
  if (factor == 0 && (head.unit == "A" || head.unit == "1"))
    s.data.push_back({head.header + ": no masses tell what 1 " + head.unit + " is in " + force +
                          ": a compliance of " + s.model.chain.independent[joint].name + " is per " +
                          head.unit + " here",
                      s.model.chain.independent[joint].name,
                      {},
                      {},
                      "write the effort in " + force +
                          " at the joint, by the motor's torque constant and the gear ratio"});
}

/// The loads by the masses of the URDF, for a log without efforts: along the references, or gravity's part by
/// the readings of a tracked arm.
void add_loads(Sanity& s) {
  const auto is = [&](LogSignal signal) {
    return std::any_of(s.log.columns.begin(), s.log.columns.end(),
                       [&](const LogColumn& c) { return c.signal == signal; });
  };
  constexpr Eigen::Index most_rows =
      1 << 18;  // of paths beside references, which would double the memory of longer records
  const bool referenced = is(LogSignal::reference);
  if (!has_masses(s.model.chain)) return;
  if (referenced ? s.log.values.rows() > most_rows : !is(LogSignal::tip)) return;
  const bool ordered = s.log.has_time();
  JointPaths paths = ordered ? joint_paths(s) : paths_of_readings(s);
  if (std::any_of(paths.begin(), paths.end(), [](const auto& p) { return !p; })) paths = paths_of_readings(s);
  const std::vector<std::optional<Loads>> loads = loads_by_masses(s, paths);
  for (std::size_t j = 0; j < loads.size(); ++j) {
    if (!loads[j]) continue;
    const IndependentJoint& joint = s.model.chain.independent[j];
    LogColumn column;
    column.signal = LogSignal::effort;
    column.index = j;
    column.unit = joint.prismatic() ? "N" : "N m";
    column.computed = true;
    column.header = joint.name + ".effort by the URDF's masses";
    s.log.columns.push_back(column);
    s.log.values.conservativeResize(Eigen::NoChange, s.log.values.cols() + 1);
    s.log.values.rightCols(1) = loads[j]->at_all(s.log.values.rows()).matrix();
  }
}

}  // namespace

void check_loads(Sanity& s) {
  if (s.log.values.rows() < fewest_rows_of_slope) return;
  const bool logged = std::any_of(s.log.columns.begin(), s.log.columns.end(),
                                  [](const LogColumn& c) { return c.signal == LogSignal::effort; });
  if (!logged) return add_loads(s);
  const JointPaths paths = joint_paths(s);
  const std::vector<std::optional<Loads>> loads = loads_by_masses(s, paths);
  for (std::size_t j = 0; j < paths.size(); ++j) make_load(s, j, paths[j], loads[j]);
}

}  // namespace qerr::sanity
