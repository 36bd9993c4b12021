#include "bound/proven/chain_form.hpp"

#include <algorithm>
#include <cmath>

namespace qerr {

namespace {

/// A rotation whose third column is the unit vector along `axis`.
Eigen::Matrix3d frame_of_axis(const Eigen::Vector3d& axis) {
  return Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), axis).toRotationMatrix();
}

void add_error(ChainForm& form, const OperationalModel& model, const IndependentError& error) {
  const Eigen::VectorXd of_independent = moved_joints(model.transmission, error);
  DirectedError e;
  e.of_joints.resize(static_cast<Eigen::Index>(form.size()));
  e.first = e.of_joints.size();
  double scale = 0;
  for (Eigen::Index k = 0; k < e.of_joints.size(); ++k) {
    const ChainJoint& joint = model.chain.joints[static_cast<std::size_t>(k)];
    e.of_joints[k] = joint.multiplier * of_independent[static_cast<Eigen::Index>(joint.coordinate)];
    if (e.of_joints[k] == 0) continue;
    if (scale == 0) scale = e.of_joints[k], e.first = k;
    e.last = k;
  }
  if (scale == 0) return;
  e.of_joints /= scale;
  e.half_width = error.half_width * std::abs(scale);
  e.mean = error.mean * scale;
  e.variance = std::pow(error.sigma * scale, 2);
  for (DirectedError& other : form.errors)
    if (other.of_joints == e.of_joints) {
      other.half_width += e.half_width;
      other.mean += e.mean;
      other.variance += e.variance;
      return;
    }
  form.errors.push_back(std::move(e));
}

void add_errors(ChainForm& form, const OperationalModel& model, const std::vector<Eigen::Matrix3d>& axes) {
  for (const IndependentError& e : independent_errors(model)) {
    if (e.where != IndependentError::Where::origin) {
      add_error(form, model, e);
      continue;
    }
    form.origins.push_back({e.link, e.link == 0 ? e.direction : axes[e.link - 1].transpose() * e.direction,
                            e.half_width, e.mean, e.sigma * e.sigma});
  }
}

}  // namespace

ChainForm chain_form(const OperationalModel& model, const std::vector<Limits>& ranges) {
  ChainForm form;
  std::vector<Eigen::Matrix3d> axes;
  Eigen::Matrix3d last = Eigen::Matrix3d::Identity();
  for (const ChainJoint& joint : model.chain.joints) {
    axes.push_back(frame_of_axis(joint.axis));
    ChainStep step;
    step.rotation = last.transpose() * joint.origin.linear() * axes.back();
    step.translation = last.transpose() * joint.origin.translation();
    step.prismatic = joint.prismatic;
    step.coordinate = joint.coordinate;
    const double a = joint.multiplier * ranges[joint.coordinate].lower + joint.offset,
                 b = joint.multiplier * ranges[joint.coordinate].upper + joint.offset;
    step.lower = std::min(a, b);
    step.upper = std::max(a, b);
    form.steps.push_back(step);
    last = axes.back();
  }
  form.tip.linear() = last.transpose() * model.chain.tip_offset.linear();
  form.tip.translation() = last.transpose() * model.chain.tip_offset.translation();
  form.tip.makeAffine();
  add_errors(form, model, axes);
  return form;
}

std::vector<std::vector<double>> distant_signs(const ChainForm& form) {
  std::size_t distant = 0;
  bool means = false;
  for (const DirectedError& e : form.errors) distant += e.last - e.first > 1, means = means || e.mean != 0;
  for (const DirectedOrigin& o : form.origins) means = means || o.mean != 0;
  std::vector<std::vector<double>> all;
  for (std::size_t c = 0; c < std::size_t{1} << (distant > 0 && !means ? distant - 1 : distant); ++c) {
    all.emplace_back();
    for (std::size_t i = 0; i < distant; ++i) all.back().push_back(c >> i & 1 ? 1 : -1);
  }
  return all;
}

std::vector<double> ChainForm::reaches() const {
  std::vector<double> reach(size() + 1);
  reach[size()] = tip.translation().norm();
  for (std::size_t k = size(); k-- > 0;) {
    const ChainStep& s = steps[k];
    // Of the fixed transform and a prismatic motion together; both ends, as the distance is convex.
    double offset = s.translation.norm();
    if (s.prismatic)
      for (const double motion : {s.lower, s.upper})
        offset = std::max(offset, (s.translation + motion * s.rotation.col(2)).norm());
    reach[k] = (offset + reach[k + 1]) * (1 + 1e-14);
  }
  return reach;
}

namespace {

void add_column(LocalError& e, double factor, bool prismatic, const Eigen::Vector3d& z,
                const Eigen::Vector3d& origin, double reach) {
  if (factor == 0) return;
  if (prismatic) {
    e.constant += factor * z;
    e.size += std::abs(factor);
    return;
  }
  e.axis += factor * z;
  e.constant -= factor * z.cross(origin);  // (u x z) . o = u . (z x o)
  e.size += std::abs(factor) * reach;
  e.moment += std::abs(factor);
}

bool of_neighbours(const DirectedError& e) { return e.last - e.first <= 1; }

/// The column of an error of one joint or of two neighbours, in the moved frame of the first.
LocalError local(const ChainForm& form, const std::vector<double>& reach, const DirectedError& e,
                 double width) {
  LocalError sum;
  sum.width = width;
  for (Eigen::Index k = e.first; k <= e.last; ++k) {
    const auto joint = static_cast<std::size_t>(k);
    const ChainStep& step = form.steps[joint];
    const bool next = k > e.first;
    add_column(sum, e.of_joints[k], step.prismatic,
               next ? Eigen::Vector3d(step.rotation.col(2)) : Eigen::Vector3d::UnitZ(),
               next ? step.translation : Eigen::Vector3d::Zero(), reach[joint + 1]);
  }
  return sum;
}

void add_own_column(const ChainForm& form, const std::vector<double>& reach, std::size_t joint, double factor,
                    LocalError& sum) {
  add_column(sum, factor, form.steps[joint].prismatic, Eigen::Vector3d::UnitZ(), Eigen::Vector3d::Zero(),
             reach[joint + 1]);
}

}  // namespace

std::vector<FrameErrors> worst_case_errors(const ChainForm& form, const std::vector<double>& distant_signs) {
  const std::vector<double> reach = form.reaches();
  std::vector<FrameErrors> frames(form.size() + 1);
  std::size_t distant = 0;
  for (const DirectedError& e : form.errors) {
    const bool near = of_neighbours(e);
    const double fixed = e.mean + (near ? 0 : distant_signs[distant++] * e.half_width);
    for (Eigen::Index k = e.first; k <= e.last; ++k) {
      const auto joint = static_cast<std::size_t>(k);
      add_own_column(form, reach, joint, fixed * e.of_joints[k], frames[joint + 1].fixed);
    }
    if (near && e.half_width > 0)
      frames[static_cast<std::size_t>(e.first) + 1].independent.push_back(
          local(form, reach, e, e.half_width));
  }
  return frames;
}

std::vector<FrameErrors> sigma_errors(const ChainForm& form) {
  const std::vector<double> reach = form.reaches();
  std::vector<FrameErrors> frames(form.size() + 1);
  for (const DirectedError& e : form.errors) {
    if (e.variance == 0) continue;
    if (of_neighbours(e)) {
      frames[static_cast<std::size_t>(e.first) + 1].independent.push_back(
          local(form, reach, e, std::sqrt(e.variance)));
      continue;
    }
    double whole = 0;
    std::vector<LocalError> parts(form.size());
    for (Eigen::Index k = e.first; k <= e.last; ++k) {
      const auto joint = static_cast<std::size_t>(k);
      add_own_column(form, reach, joint, e.of_joints[k], parts[joint]);
      whole += parts[joint].size;
    }
    for (std::size_t joint = 0; joint < parts.size(); ++joint) {
      if (parts[joint].size == 0) continue;
      parts[joint].width = std::sqrt(e.variance * whole / parts[joint].size);
      frames[joint + 1].independent.push_back(parts[joint]);
    }
  }
  return frames;
}

std::vector<double> reaches_before_motion(const ChainForm& form) {
  std::vector<double> reach = form.reaches();
  for (std::size_t k = 0; k < form.size(); ++k)
    if (form.steps[k].prismatic)
      reach[k + 1] += std::max(std::abs(form.steps[k].lower), std::abs(form.steps[k].upper));
  return reach;
}

}  // namespace qerr
