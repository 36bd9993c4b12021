// The constants of the errors along a path: columns, scales and bounds.
#include <algorithm>
#include <cmath>
#include <limits>

#include "lanes/lanes.hpp"
#include "qerr/bound/operational_error.hpp"
#include "simulate/kernels.hpp"
#include "simulate/run.hpp"
#include "simulate/sensing.hpp"

namespace qerr {

namespace {

bool needs_orientation(const OperationalModel& model) {
  return model.frame == CoordinateFrame::tip ||
         std::ranges::any_of(model.coordinates, [](Coordinate c) { return !is_position(c); });
}

bool same_origins(const Chain& a, const Chain& b) {
  for (std::size_t k = 0; k < a.joints.size(); ++k)
    if (a.joints[k].origin.matrix() != b.joints[k].origin.matrix()) return false;
  return a.tip_offset.matrix() == b.tip_offset.matrix();
}

/// Joints that each move by one coordinate with factor 1.
std::vector<FoldedJoint> moved_directly(const FoldedChain& chain) {
  std::vector<FoldedJoint> joints = chain.joints;
  for (std::size_t k = 0; k < joints.size(); ++k) {
    joints[k].coordinate = k;
    set_motion(joints[k], 1, 0);
  }
  return joints;
}

FoldedPath along(const FoldedChain& chain, const std::vector<FoldedJoint>& joints) {
  FoldedPath path = path_of(chain);
  path.joints = joints.data();
  return path;
}

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

PathErrors::PathErrors(const OperationalModel& model, const Chain& built, const Eigen::VectorXd& center_mean,
                       InstructionSet set)
    : channels_(model),
      chain_(fold(model.chain, needs_orientation(model))),
      built_(fold(built, needs_orientation(model))),
      as_modelled_(same_origins(model.chain, built)),
      kernels_(select_kernels<SimulationKernels>(set)),
      center_mean_(center_mean.begin(), center_mean.end()) {
  for (const FoldedJoint& joint : chain_.joints) scale_.push_back(joint.sign);
  for (const Coordinate c : model.coordinates) coordinates_.push_back(static_cast<int>(c));
  add_columns(model);
  fix_scale(model);
  bound(model);
  set_plan(model);
  const auto of_lanes = [&](std::size_t rows) { return AlignedNumbers(rows * batch_size); };
  const std::size_t m = coordinates_.size(), joints = chain_.joints.size();
  rows_ = of_lanes(plan_.width);
  variance_ = of_lanes(m);
  rigorous_ = AlignedNumbers(m * kernels_.lanes);
  deviation_ = AlignedNumbers(m * kernels_.lanes);
  scratch_ = AlignedNumbers(kernels_.errors_scratch_size(plan_));
  for (AlignedNumbers* a : {&direct_joint_, &direct_built_joint_, &direct_estimate_}) *a = of_lanes(joints);
  direct_chain_ = moved_directly(chain_);
  direct_built_ = moved_directly(built_);
}

void PathErrors::reduce_angles(const FoldedChain& chain, const double* joints,
                               const AlignedNumbers& to) const {
  for (std::size_t k = 0; k < chain.joints.size(); ++k) {
    const FoldedJoint& joint = chain.joints[k];
    for (std::size_t i = 0; i < batch_size; ++i) {
      const double motion = joint.multiplier * joints[joint.coordinate * batch_size + i];
      to[k * batch_size + i] =
          joint.offset + (joint.prismatic ? motion : std::atan2(std::sin(motion), std::cos(motion)));
    }
  }
}

bool PathErrors::within_lanes(const FoldedChain& chain, const double* joints) const {
  return std::ranges::all_of(chain.joints, [&](const FoldedJoint& joint) {
    return joint.prismatic ||
           kernels_.within(joints + joint.coordinate * batch_size, std::abs(joint.multiplier),
                           lanes::largest_angle - std::abs(joint.offset));
  });
}

void PathErrors::share(const PathBatch& path) {
  if (path_sines_.size() == 0) path_sines_ = AlignedNumbers(2 * chain_.joints.size() * batch_size);
  shared_ = within_lanes(chain_, path.joints());
  if (shared_) kernels_.sines(plan_.chain, path.joints(), path_sines_.data());
}

/// @returns whether the displacement is small enough for the series of `SmallAngle`
bool PathErrors::displace(const double* shift) {
  displacements_.clear();
  for (const FoldedJoint& joint : chain_.joints) {
    const double d = joint.multiplier * shift[joint.coordinate];
    if (!joint.prismatic && !(std::abs(d) <= Displacement::largest)) return false;
    displacements_.emplace_back(d);
    if (joint.prismatic) displacements_.back().sine = d;
  }
  return true;
}

void PathErrors::operator()(const SensedBatch& b) {
  const bool near_path = shared_ && displace(b.shift);
  PathErrorBatch batch{b.joint,
                       b.joint,
                       b.estimate,
                       b.encoder,
                       b.measured,
                       near_path ? path_sines_.data() : nullptr,
                       displacements_.data(),
                       rows_.data(),
                       variance_.data(),
                       rigorous_.data(),
                       deviation_.data(),
                       scratch_.data()};
  if ((near_path || within_lanes(chain_, b.joint)) && within_lanes(chain_, b.estimate) &&
      (as_modelled_ || within_lanes(built_, b.joint)))
    return kernels_.errors(plan_, batch);
  PathErrorPlan plan = plan_;
  plan.chain = along(chain_, direct_chain_);
  plan.built = along(built_, direct_built_);
  reduce_angles(chain_, b.joint, direct_joint_);
  reduce_angles(built_, b.joint, direct_built_joint_);
  reduce_angles(chain_, b.estimate, direct_estimate_);
  batch.path_sines = nullptr;
  batch.joint = direct_joint_.data();
  batch.built_joint = direct_built_joint_.data();
  batch.estimate = direct_estimate_.data();
  kernels_.errors(plan, batch);
}

Eigen::VectorXd PathErrors::largest(const AlignedNumbers& of_lanes) const {
  Eigen::VectorXd all(channels_.coordinates);
  for (std::size_t c = 0; c < plan_.coordinates; ++c) {
    const double* const values = of_lanes.data() + c * kernels_.lanes;
    all[c] = coordinates_[c] >= 6 ? std::numeric_limits<double>::infinity()
                                  : *std::max_element(values, values + kernels_.lanes);
  }
  return all;
}

/// @param of_independent  derivative of the independent joints with respect to the error
void PathErrors::add_column(const Chain& chain, const Eigen::VectorXd& of_independent, double mean,
                            double half_width) {
  ErrorColumn column{parts_.size(), 0, false, false, 0, {}, mean, half_width};
  for (std::size_t k = 0; k < chain.joints.size(); ++k) {
    const ChainJoint& joint = chain.joints[k];
    const double factor = joint.multiplier * of_independent[joint.coordinate];
    if (factor != 0) parts_.push_back({k, factor});
  }
  column.parts = parts_.size() - column.first;
  columns_.push_back(column);
}

void PathErrors::add_origin(const IndependentError& s) {
  ErrorColumn column{parts_.size(), 0, false, true, s.link, {}, s.mean, s.half_width};
  Eigen::Vector3d direction = s.direction;
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
      add_origin(e);
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
    per_column_.push_back(r.per_column[k] / std::abs(scale_[k]));
}

void PathErrors::set_plan(const OperationalModel& model) {
  const auto any_coordinate = [&](auto property) { return std::ranges::any_of(model.coordinates, property); };
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
  plan_.mixed = std::ranges::any_of(columns_, [](const ErrorColumn& c) { return !c.direct && !c.origin; });
  plan_.per_column = per_column_.data();
  plan_.center_mean = center_mean_.data();
  const auto padded_to_lanes = [&](std::size_t count) {
    return (count + kernels_.lanes - 1) / kernels_.lanes * kernels_.lanes;
  };
  plan_.width = padded_to_lanes(channels_.count());
}

PathBatch::PathBatch(const Motion& motion, InstructionSet set)
    : path_(motion), sample_rate_(motion.sample_rate), set_(set) {}

void PathBatch::at(std::uint64_t first, std::size_t count) {
  if (time_.size() == 0) {  // allocated on first use: runs that share a batch do not need their own
    time_ = AlignedNumbers(batch_size);
    joints_ = AlignedNumbers(path_.joints() * batch_size);
  }
  first_ = first;
  count_ = count;
  select_kernels<SimulationKernels>(set_).times(static_cast<double>(first), count, sample_rate_,
                                                time_.data());
  for (std::size_t joint = 0; joint < path_.joints(); ++joint)
    path_.positions(joint, time_.data(), joints_.data() + joint * batch_size, set_);
}

}  // namespace qerr
