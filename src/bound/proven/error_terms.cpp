#include <algorithm>
#include <cmath>

#include "bound/proven/box_bound.hpp"
#include "bound/signal_errors.hpp"

namespace qerr {

ErrorTerms::ErrorTerms(const OperationalModel& model, std::size_t coordinate, bool sigma) : sigma_(sigma) {
  const Coordinate c = *all_signals(model)[coordinate].coordinate;
  length_ = is_length(c);
  const Coordinate first = length_ ? first_component(c) : c;
  const bool rotation = is_rotation_vector(first);
  row_ = static_cast<Eigen::Index>(first) - (rotation ? 3 : 0);
  in_tip_frame_ = model.frame == CoordinateFrame::tip && !length_;  // a length is the same in both
  add_axes(model, rotation);
  add_terms(model, rotation);
  if (model.along_motion) add_along_motion(model, c);
}

void ErrorTerms::add_axes(const OperationalModel& model, bool rotation) {
  const std::vector<IndependentError> errors = independent_errors(model);
  axis_of_error_.assign(errors.size(), 0);
  const auto add_origins = [&](std::size_t link) {
    for (std::size_t s = 0; s < errors.size() && !rotation; ++s) {
      if (errors[s].where != IndependentError::Where::origin || errors[s].link != link) continue;
      axis_of_error_[s] = axes_.size();
      axes_.push_back({.axis = errors[s].direction});
    }
  };
  for (std::size_t k = 0; k < model.chain.joints.size(); ++k) {
    const ChainJoint& joint = model.chain.joints[k];
    add_origins(k);
    const TermAxis axis{
        joint.origin,     joint.axis,  !joint.prismatic, true, static_cast<std::ptrdiff_t>(joint.coordinate),
        joint.multiplier, joint.offset};
    column_of_joint_.push_back(axes_.size());
    sign_of_joint_.push_back(1);
    if (rotation)
      add_turning_axis(axis);
    else
      axes_.push_back(axis);
  }
  add_origins(model.chain.joints.size());
  tip_ = model.chain.tip_offset;
}

/// A fixed direction, which has the weights, and behind it the axis that turns. Axes that follow each other
/// in parallel, at every configuration, share the direction of the first.
void ErrorTerms::add_turning_axis(TermAxis axis) {
  constexpr double parallel = 8 * machine_epsilon;
  if (!axis.turns) {
    axis.coordinate = -1;  // it does not turn the tip
    axes_.push_back(axis);
    return;
  }
  Eigen::Vector3d direction = axis.before.linear() * axis.axis;  // behind the axis that turned last
  std::size_t last = axes_.size();
  for (; last > 0 && !axes_[last - 1].turns; --last) direction = axes_[last - 1].before.linear() * direction;
  if (last > 0 && direction.cross(axes_[last - 1].axis).norm() <= parallel) {
    const std::size_t before =
        column_of_joint_.size() - 2 - (axes_.size() - last);  // the joint that turned last
    column_of_joint_.back() = column_of_joint_[before];
    sign_of_joint_.back() =
        direction.dot(axes_[last - 1].axis) < 0 ? -sign_of_joint_[before] : sign_of_joint_[before];
  } else {
    axes_.push_back({.before = axis.before, .axis = axis.axis});
    axis.before = Eigen::Isometry3d::Identity();
  }
  axes_.push_back(axis);
}

/// Terms along the same direction of the joints have one corner: their half widths and means add.
void ErrorTerms::add_term(const Eigen::VectorXd& weights, double half_width, double mean, double sigma) {
  if (weights.isZero(0) || (sigma_ ? sigma == 0 : half_width == 0 && mean == 0)) return;
  for (ErrorTerm& term : terms_)
    if (term.weights == weights) {
      term.half_width += half_width;
      term.mean += mean;
      term.sigma = std::hypot(term.sigma, sigma);
      return;
    }
  terms_.push_back({weights, half_width, mean, sigma});
}

void ErrorTerms::add_terms(const OperationalModel& model, bool rotation) {
  const auto axes = std::ssize(axes_);
  const auto of_joints = [&](const Eigen::VectorXd& independent) {
    Eigen::VectorXd weights = Eigen::VectorXd::Zero(axes);
    for (std::size_t k = 0; k < model.chain.joints.size(); ++k) {
      const ChainJoint& joint = model.chain.joints[k];
      if (rotation && joint.prismatic) continue;
      weights[column_of_joint_[k]] += sign_of_joint_[k] * joint.multiplier * independent[joint.coordinate];
    }
    return weights;
  };
  const std::vector<IndependentError> errors = independent_errors(model);
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const IndependentError& e = errors[i];
    if (e.where != IndependentError::Where::origin) {
      add_term(of_joints(moved_joints(model.transmission, e)), e.half_width, e.mean, e.sigma);
      continue;
    }
    if (rotation) continue;
    if (length_ && !sigma_)
      added_ += std::abs(e.mean) + e.half_width;
    else
      add_term(Eigen::VectorXd::Unit(axes, axis_of_error_[i]), e.half_width, e.mean, e.sigma);
  }
}

void ErrorTerms::add_along_motion(const OperationalModel& model, Coordinate c) {
  const SignalMoments& tip = model.along_motion->tip;
  double peak = 0, variance = 0;
  for (std::size_t i = 0; i < model.coordinates.size(); ++i) {
    const Coordinate other = model.coordinates[i];
    const bool part = length_ ? !is_euler_angle(other) &&
                                    is_rotation_vector(other) == is_rotation_vector(first_component(c))
                              : other == c;
    if (!part) continue;
    peak = std::hypot(peak, tip.peak[i]);
    variance += tip.covariance(i, i);
  }
  added_ = sigma_ ? std::sqrt(variance) : added_ + peak;
}

std::vector<std::size_t> ErrorTerms::moved_by(std::size_t joint) const {
  std::vector<std::size_t> list;
  for (std::size_t k = 0; k < axes_.size(); ++k)
    if (axes_[k].coordinate == static_cast<std::ptrdiff_t>(joint) && axes_[k].multiplier != 0)
      list.push_back(k);
  return list;
}

double ErrorTerms::largest_motion(const TermAxis& axis, const std::vector<Limits>& ranges) const {
  if (axis.coordinate < 0) return std::abs(axis.offset);
  const Limits& range = ranges[axis.coordinate];
  return std::abs(axis.multiplier) * std::max(std::abs(range.lower), std::abs(range.upper)) +
         std::abs(axis.offset);
}

Eigen::VectorXd ErrorTerms::longest_columns(const std::vector<Limits>& ranges) const {
  Eigen::VectorXd longest(std::ssize(axes_));
  double beyond = tip_.translation().norm();
  for (std::size_t k = axes_.size(); k-- > 0;) {
    const TermAxis& axis = axes_[k];
    longest[k] = axis.turns ? beyond : 1;
    if (!axis.turns && axis.coordinate >= 0) beyond += largest_motion(axis, ranges);
    beyond += axis.before.translation().norm();
  }
  return longest;
}

ErrorTerms ErrorTerms::along_any_direction(std::size_t joints) const {
  ErrorTerms turned = *this;
  turned.length_ = false;
  turned.row_ = 0;
  turned.turned_base_ = true;
  const auto first = static_cast<std::ptrdiff_t>(joints);
  const TermAxis about_z{.axis = Eigen::Vector3d::UnitZ(), .turns = true, .coordinate = first};
  const TermAxis about_y{.axis = Eigen::Vector3d::UnitY(), .turns = true, .coordinate = first + 1};
  turned.axes_.insert(turned.axes_.begin(), {about_z, about_y});
  for (ErrorTerm& term : turned.terms_) {
    Eigen::VectorXd weights = Eigen::VectorXd::Zero(term.weights.size() + 2);
    weights.tail(term.weights.size()) = term.weights;
    term.weights = std::move(weights);
  }
  return turned;
}

TermColumns ErrorTerms::columns(const Eigen::VectorXd& q) const {
  const auto count = std::ssize(axes_);
  TermColumns c{Eigen::Matrix3Xd(3, count), Eigen::Matrix3Xd::Zero(3, count)};
  Eigen::Matrix3Xd origins(3, count);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  for (Eigen::Index k = 0; k < count; ++k) {
    const TermAxis& axis = axes_[k];
    const double motion = axis.offset + (axis.coordinate < 0 ? 0 : axis.multiplier * q[axis.coordinate]);
    pose = pose * axis.before;
    origins.col(k) = pose.translation();
    c.columns.col(k) = pose.linear() * axis.axis;
    if (axis.turns)
      pose.rotate(Eigen::AngleAxisd(motion, axis.axis));
    else if (axis.coordinate >= 0)
      pose.translate(motion * axis.axis);
  }
  pose = pose * tip_;
  for (Eigen::Index k = 0; k < count; ++k) {
    if (!axes_[k].turns) continue;
    c.turning.col(k) = c.columns.col(k);
    c.columns.col(k) = c.turning.col(k).cross(pose.translation() - origins.col(k));
  }
  if (in_tip_frame_) {
    c.columns = pose.linear().transpose() * c.columns;
    c.turning = pose.linear().transpose() * c.turning;
  }
  return c;
}

Eigen::Matrix3Xd ErrorTerms::vectors(const TermColumns& c) const {
  Eigen::Matrix3Xd v(3, std::ssize(terms_));
  for (std::size_t g = 0; g < terms_.size(); ++g) v.col(g) = c.columns * terms_[g].weights;
  return v;
}

double ErrorTerms::value(const Eigen::Matrix3Xd& v) const {
  double sum = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (Eigen::Index g = 0; g < v.cols(); ++g) {
    const ErrorTerm& term = terms_[g];
    mean += term.mean * v.col(g);
    if (sigma_)
      sum += term.sigma * term.sigma * (length_ ? v.col(g).squaredNorm() : v(row_, g) * v(row_, g));
    else if (!length_)
      sum += term.half_width * std::abs(v(row_, g));
  }
  if (sigma_) return std::sqrt(sum + added_ * added_);
  if (!length_) return sum + std::abs(mean[row_]) + added_;
  Eigen::Matrix3Xd corners = v;
  for (Eigen::Index g = 0; g < v.cols(); ++g) corners.col(g) *= terms_[g].half_width;
  return largest_corner(mean, corners) + added_;
}

}  // namespace qerr
