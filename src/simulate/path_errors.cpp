#include "simulate/path_errors.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lanes/lanes.hpp"

namespace qerr {

namespace {

bool needs_orientation(const OperationalModel& model) {
  return model.frame == CoordinateFrame::tip ||
         std::any_of(model.coordinates.begin(), model.coordinates.end(),
                     [](Coordinate c) { return !is_position(c); });
}

bool same_origins(const Chain& a, const Chain& b) {
  for (std::size_t k = 0; k < a.joints.size(); ++k)
    if (a.joints[k].origin.matrix() != b.joints[k].origin.matrix()) return false;
  return true;
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
  return std::all_of(chain.joints.begin(), chain.joints.end(), [&](const FoldedJoint& joint) {
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

void PathErrors::operator()(const SensedBatch& b, const Wanted& wanted) {
  const bool near_path = shared_ && displace(b.shift);
  RunStatistics::Place place{};
  if (wanted.statistics) place = wanted.statistics->place(batch_size, wanted.block);
  each_ = wanted.each;
  PathErrorBatch batch{b.joint,
                       b.joint,
                       b.estimate,
                       b.encoder,
                       b.measured,
                       near_path ? path_sines_.data() : nullptr,
                       displacements_.data(),
                       wanted.rows ? rows_.data() : nullptr,
                       place.tally,
                       place.fresh,
                       !wanted.rows && !wanted.statistics,
                       each_,
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
    all[static_cast<Eigen::Index>(c)] = coordinates_[c] >= 6
                                            ? std::numeric_limits<double>::infinity()
                                            : *std::max_element(values, values + kernels_.lanes);
  }
  return all;
}

}  // namespace qerr
