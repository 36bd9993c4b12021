#include <algorithm>
#include <cmath>
#include <numbers>

#include "bound/proven/chain_bound.hpp"
#include "bound/proven/recursion.hpp"

namespace qerr {

namespace {

/// Rounding errors of a table's value, over the largest value: fewer than 1000 operations of 2^-53 each.
constexpr double rotation_rounding = 1e-13;

/// scale |u . direction| + mean u . direction, or variance (u . direction)^2.
struct AxisError {
  Eigen::Vector3d direction;
  double half_width = 0, mean = 0, variance = 0;
};

/// A stage of the recursion: L, the rotation to the frame of the next one, and the joint's motion.
struct RotationStage : DirectionTable<double> {
  std::vector<AxisError> errors;
  Eigen::Matrix3d to_next = Eigen::Matrix3d::Identity();
  double lower = 0, upper = 0;
  double size = 0;        ///< largest |F| for |u| = 1
  double horizontal = 0;  ///< largest F of the samples of horizontal u
};

/// Errors of each joint's moved frame; [0] is the base.
using ErrorsOfFrames = std::vector<std::vector<AxisError>>;

/// @param distant_signs  of the errors of distant joints; empty: relax them
ErrorsOfFrames errors_of_frames(const ChainForm& form, const std::vector<double>* distant_signs) {
  ErrorsOfFrames frames(form.size() + 1);
  std::size_t distant = 0;
  const auto angular = [&](Eigen::Index k) { return !form.steps[k].prismatic; };
  for (const DirectedError& e : form.errors) {
    if (e.last - e.first <= 1) {
      AxisError sum{Eigen::Vector3d::Zero(), e.half_width, e.mean, e.variance};
      if (angular(e.first)) sum.direction += e.of_joints[e.first] * Eigen::Vector3d::UnitZ();
      if (e.last > e.first && angular(e.last))
        sum.direction += e.of_joints[e.last] * form.steps[e.last].rotation.col(2);
      frames[static_cast<std::size_t>(e.first) + 1].push_back(sum);
      continue;
    }
    const double sign = distant_signs ? (*distant_signs)[distant++] : 0;
    double whole = 0;
    for (Eigen::Index k = e.first; k <= e.last; ++k)
      if (angular(k)) whole += std::abs(e.of_joints[k]);
    for (Eigen::Index k = e.first; k <= e.last; ++k)
      if (angular(k) && e.of_joints[k] != 0)
        frames[static_cast<std::size_t>(k) + 1].push_back({e.of_joints[k] * Eigen::Vector3d::UnitZ(), 0,
                                                           e.mean + sign * e.half_width,
                                                           e.variance * whole / std::abs(e.of_joints[k])});
  }
  return frames;
}

void append(std::vector<AxisError>& to, const std::vector<AxisError>& from, const Eigen::Matrix3d& turn) {
  for (AxisError e : from) {
    e.direction = turn * e.direction;
    to.push_back(e);
  }
}

class RotationRecursion {
 public:
  RotationRecursion(const ChainForm& form, RotationAxes axes, const ErrorsOfFrames& errors, bool sigma);
  void run(double cells);
  double along(const Eigen::Vector3d& u) const;
  double length() const;

 private:
  double at(std::size_t stage, const Eigen::Vector3d& u) const;
  double of_table(std::size_t stage, const Eigen::Vector3d& u) const;

  std::vector<RotationStage> stages_;  // [0]: no motion
  bool sigma_, even_ = true;
};

RotationRecursion::RotationRecursion(const ChainForm& form, RotationAxes axes, const ErrorsOfFrames& errors,
                                     bool sigma)
    : sigma_(sigma) {
  for (const auto& frame : errors)
    for (const AxisError& e : frame) even_ = even_ && (sigma || e.mean == 0);
  const std::size_t n = form.size();
  stages_.push_back({});
  if (axes == RotationAxes::tip) append(stages_[0].errors, errors[n], Eigen::Matrix3d::Identity());
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t joint = axes == RotationAxes::base ? i : n - 1 - i;
    const ChainStep& step = form.steps[joint];
    // To the frame before the motion; the errors behind it.
    const bool base = axes == RotationAxes::base;
    const Eigen::Matrix3d before =
        base ? Eigen::Matrix3d(step.rotation.transpose()) : Eigen::Matrix3d::Identity();
    const Eigen::Matrix3d behind = base ? Eigen::Matrix3d::Identity() : step.rotation;
    stages_.back().to_next = before * stages_.back().to_next;
    if (!step.prismatic) {
      RotationStage next;
      next.lower = base ? -step.upper : step.lower;
      next.upper = base ? -step.lower : step.upper;
      stages_.push_back(next);
    }
    stages_.back().to_next = behind * stages_.back().to_next;
    append(stages_.back().errors, errors[base ? joint + 1 : joint], stages_.back().to_next.transpose());
  }
  double size = 0;
  for (std::size_t i = stages_.size(); i-- > 0;) {
    for (const AxisError& e : stages_[i].errors)
      size += (sigma ? std::sqrt(e.variance) : e.half_width + std::abs(e.mean)) * e.direction.norm();
    stages_[i].size = size;
  }
}

double RotationRecursion::of_table(std::size_t stage, const Eigen::Vector3d& u) const {
  const RotationStage& s = stages_[stage];
  const DirectionStencil stencil = direction_weights(s.directions, u);
  return s.added(stencil.direction_residual * s.size, stencil, 1, 0);
}

/// F at a direction of the moved frame.
double RotationRecursion::at(std::size_t stage, const Eigen::Vector3d& u) const {
  const RotationStage& s = stages_[stage];
  const double beyond = stage + 1 < stages_.size() ? of_table(stage + 1, s.to_next * u) : 0;
  double sum = sigma_ ? beyond * beyond : beyond;
  for (const AxisError& e : s.errors) {
    const double c = u.dot(e.direction);
    sum += sigma_ ? e.variance * c * c : e.half_width * std::abs(c) + e.mean * c;
  }
  return sigma_ ? std::sqrt(sum) : sum;
}

void RotationRecursion::run(double cells) {
  const double step = std::numbers::pi / 2 / cells;
  for (std::size_t i = stages_.size(); i-- > 1;) {
    RotationStage& s = stages_[i];
    s.arc = arc_grid(s.lower, s.upper, step);
    s.directions = direction_grid(even_, step, s.arc);
    for (std::size_t j = 0; j < s.arc.sample_cos.size(); ++j)
      s.horizontal =
          std::max(s.horizontal,
                   at(i, direction_frame(std::numbers::pi / 2, s.arc.sample_cos[j], s.arc.sample_sin[j]).u));
    const double arc = s.arc.intervals > 0 ? 1 / std::cos(s.arc.spacing / 2) - 1 : 0;
    tabulate(
        s, 1, [&](const DirectionFrame& frame, double* value) { *value = at(i, frame.u); },
        [&](std::size_t row, std::size_t, double* value) {
          const double between = arc * std::sin(s.directions.polar(row)) * s.horizontal;
          *value = *value + between + rotation_rounding * s.size;
        });
  }
}

double RotationRecursion::along(const Eigen::Vector3d& u) const {
  const double there = at(0, u);
  return (even_ ? there : std::max(there, at(0, -u))) + rotation_rounding * stages_[0].size;
}

double RotationRecursion::length() const {
  if (stages_.size() == 1) return 0;  // no joint turns
  const DirectionGrid& g = stages_[1].directions;
  std::vector<double> values;  // of F_0: errors of joints that slide before the first that turns are in L_0
  for (std::size_t row = 0; row < g.rows; ++row)
    for (std::size_t column = 0; column < g.columns(); ++column) {
      const Eigen::Vector3d u =
          direction_frame(g.polar(row), g.azimuths->node_cos[column], g.azimuths->node_sin[column]).u;
      double value = stages_[1].table[row * g.columns() + column];
      for (const AxisError& e : stages_[0].errors) {
        const double c = (stages_[0].to_next * e.direction).dot(u);
        value += e.half_width * std::abs(c) + e.mean * c;
      }
      values.push_back(value);
    }
  return largest_over_directions(g, values) + rotation_rounding * stages_[0].size;
}

/// From the axes of the figures to the frame in which the recursion starts.
Eigen::Matrix3d axes_of_first_frame(const ChainForm& form, RotationAxes axes) {
  if (axes == RotationAxes::base) return Eigen::Matrix3d::Identity();
  return form.tip.linear();
}

}  // namespace

RotationBound rotation_worst_case_bound(const ChainForm& form, RotationAxes axes,
                                        const std::vector<Eigen::Vector3d>& directions, double cells) {
  RotationBound bound;
  bound.along.resize(directions.size());
  for (const std::vector<double>& signs : distant_signs(form)) {
    const ErrorsOfFrames errors = errors_of_frames(form, &signs);
    RotationRecursion r(form, axes, errors, false);
    r.run(cells);
    for (std::size_t i = 0; i < directions.size(); ++i)
      bound.along[i] = std::max(bound.along[i], r.along(axes_of_first_frame(form, axes) * directions[i]));
    if (axes == RotationAxes::base) bound.length = std::max(bound.length, r.length());
  }
  return bound;
}

RotationBound rotation_sigma_bound(const ChainForm& form, RotationAxes axes,
                                   const std::vector<Eigen::Vector3d>& directions, double cells) {
  RotationBound bound;
  const ErrorsOfFrames errors = errors_of_frames(form, nullptr);
  if (!directions.empty()) {
    RotationRecursion r(form, axes, errors, true);
    r.run(cells);
    for (const Eigen::Vector3d& u : directions)
      bound.along.push_back(r.along(axes_of_first_frame(form, axes) * u));
  }
  double variance = 0;
  for (const auto& frame : errors)
    for (const AxisError& e : frame) variance += e.variance * e.direction.squaredNorm();
  bound.length = std::sqrt(variance) * (1 + rotation_rounding);
  return bound;
}

}  // namespace qerr
