// The constants of the errors along a path: columns, scales and bounds.

#include <algorithm>
#include <cmath>
#include <limits>

#include "bound/linearization_remainder.hpp"
#include "simulate/path_errors.hpp"

namespace qerr {

namespace {

/// Upper bound on the Jacobian columns of revolute joints in any configuration; infinite if a joint is
/// prismatic.
double longest_arm(const Chain& chain) {
  double sum = chain.tip_offset.translation().norm();
  for (const ChainJoint& joint : chain.joints) {
    if (joint.prismatic) return std::numeric_limits<double>::infinity();
    sum += joint.origin.translation().norm();
  }
  return sum;
}

}  // namespace

/// @param of_independent  derivative of the independent joints with respect to the error
void PathErrors::add_column(const Chain& chain, const Eigen::VectorXd& of_independent, double mean,
                            double half_width) {
  ErrorColumn column{parts_.size(), 0, false, false, 0, {}, mean, half_width};
  for (std::size_t k = 0; k < chain.joints.size(); ++k) {
    const ChainJoint& joint = chain.joints[k];
    const double factor = joint.multiplier * of_independent[static_cast<Eigen::Index>(joint.coordinate)];
    if (factor != 0) parts_.push_back({k, factor});
  }
  column.parts = parts_.size() - column.first;
  columns_.push_back(column);
}

void PathErrors::add_origin(const Chain& chain, const IndependentError& s) {
  ErrorColumn column{parts_.size(), 0, false, true, s.link, {}, s.mean, s.half_width};
  Eigen::Vector3d direction = chain.joints[s.link].parent_axes * s.direction;
  if (s.link > 0) direction = chain_.link_axes[s.link - 1] * direction;
  Eigen::Map<Eigen::Vector3d>(column.direction) = direction;
  columns_.push_back(column);
}

void PathErrors::add_columns(const OperationalModel& model) {
  for (const Encoder& encoder : model.transmission.encoders)
    per_resolution_.push_back(1 / encoder.resolution);
  const std::vector<IndependentError> errors = independent_errors(model);
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const IndependentError& e = errors[i];
    const double unit = i < per_resolution_.size() ? model.transmission.encoders[i].resolution : 1;
    if (e.where == IndependentError::Where::origin)
      add_origin(model.chain, e);
    else
      add_column(model.chain, moved_joints(model.transmission, e) * unit, e.mean / unit, e.half_width / unit);
  }
}

/// Scales the columns of joints so that an encoder that moves a single joint has that column with factor 1.
void PathErrors::fix_scale(const OperationalModel& model) {
  std::vector<double> first(model.chain.joints.size(), 0);
  for (const ColumnPart& part : parts_)
    if (first[part.joint] == 0) first[part.joint] = part.factor;
  for (std::size_t k = 0; k < first.size(); ++k)
    if (first[k] == 0) first[k] = 1;
  for (std::size_t k = 0; k < first.size(); ++k) scale_[k] *= first[k];
  for (ColumnPart& part : parts_) part.factor /= first[part.joint];
  for (ErrorColumn& column : columns_)
    column.direct = !column.origin && column.parts == 1 && parts_[column.first].factor == 1;
}

void PathErrors::bound(const OperationalModel& model) {
  const LinearizationRemainder r = linearization_remainder(model.chain, joint_error(model).worst_case);
  plan_.remainder = r.position;
  plan_.rotation = r.rotation;
  plan_.rotation_angle = r.rotation_angle;
  const double arm = longest_arm(model.chain);
  plan_.largest_remainder =
      r.per_column.sum() > 0 ? r.position + r.per_column.sum() * (1 + 1e-12) * arm : r.position;
  for (std::size_t k = 0; k < scale_.size(); ++k)
    per_column_.push_back(r.per_column[static_cast<Eigen::Index>(k)] / std::abs(scale_[k]));
}

void PathErrors::set_plan(const OperationalModel& model) {
  const auto any_coordinate = [&](auto property) {
    return std::any_of(model.coordinates.begin(), model.coordinates.end(), property);
  };
  plan_.chain = path_of(chain_);
  plan_.built = path_of(built_);
  plan_.as_modelled = as_modelled_;
  plan_.scale = scale_.data();
  plan_.encoders = model.transmission.encoders.size();
  plan_.sources = model.sources.size();
  plan_.columns = columns_.data();
  plan_.parts = parts_.data();
  plan_.per_resolution = per_resolution_.data();
  plan_.coordinates = coordinates_.size();
  plan_.rows = coordinates_.data();
  plan_.rotations = any_coordinate(is_rotation_vector);
  plan_.angles = any_coordinate(is_euler_angle);
  plan_.biased = channels_.biased;
  plan_.tip_frame = model.frame == CoordinateFrame::tip;
  plan_.mixed = std::any_of(columns_.begin(), columns_.end(),
                            [](const ErrorColumn& c) { return !c.direct && !c.origin; });
  plan_.per_column = per_column_.data();
  plan_.center_mean = center_mean_.data();
  const auto padded_to_lanes = [&](std::size_t count) {
    return (count + kernels_.lanes - 1) / kernels_.lanes * kernels_.lanes;
  };
  plan_.width = padded_to_lanes(static_cast<std::size_t>(channels_.count()));
}

}  // namespace qerr
