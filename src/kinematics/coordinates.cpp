#include "qerr/kinematics/coordinates.hpp"

#include <cmath>
#include <limits>

#include "kinematics/kernels.hpp"
#include "kinematics/sampler.hpp"

namespace qerr {

const std::vector<CoordinateInfo>& coordinate_list() {
  static const std::vector<CoordinateInfo> list{
      {Coordinate::x, "x", "m", "position of the tip along x of the frame"},
      {Coordinate::y, "y", "m", "position of the tip along y of the frame"},
      {Coordinate::z, "z", "m", "position of the tip along z of the frame"},
      {Coordinate::rx, "rx", "rad", "small rotation of the tip about x of the frame"},
      {Coordinate::ry, "ry", "rad", "small rotation of the tip about y of the frame"},
      {Coordinate::rz, "rz", "rad", "small rotation of the tip about z of the frame"},
      {Coordinate::roll, "roll", "rad",
       "roll of R = Rz(yaw) Ry(pitch) Rx(roll); singular at pitch = +-90 deg"},
      {Coordinate::pitch, "pitch", "rad",
       "pitch of R = Rz(yaw) Ry(pitch) Rx(roll); without a rate at +-90 deg"},
      {Coordinate::yaw, "yaw", "rad", "yaw of R = Rz(yaw) Ry(pitch) Rx(roll); singular at pitch = +-90 deg"},
      {Coordinate::xyz, "xyz", "m", "length of the vector of x y z"},
      {Coordinate::rxyz, "rxyz", "rad", "length of the vector of rx ry rz"},
  };
  return list;
}

const CoordinateInfo& info(Coordinate c) { return coordinate_list()[static_cast<std::size_t>(c)]; }

std::optional<Coordinate> find_coordinate(std::string_view name) {
  for (const CoordinateInfo& row : coordinate_list())
    if (row.name == name) return row.coordinate;
  return std::nullopt;
}

double cosine_of_pitch(const Eigen::Matrix3d& r) { return std::hypot(r(0, 0), r(1, 0)); }

namespace {

/// Rates of roll, pitch and yaw per unit of angular velocity in the base frame (3 x 3).
Eigen::Matrix3d euler_rates(const Eigen::Matrix3d& r) {
  const double cosine = cosine_of_pitch(r);
  if (cosine < gimbal_lock) return Eigen::Matrix3d::Constant(std::numeric_limits<double>::infinity());
  const double cos_yaw = r(0, 0) / cosine, sin_yaw = r(1, 0) / cosine, tan_pitch = -r(2, 0) / cosine;
  Eigen::Matrix3d rates;
  rates << cos_yaw / cosine, sin_yaw / cosine, 0,  //
      -sin_yaw, cos_yaw, 0,                        //
      tan_pitch * cos_yaw, tan_pitch * sin_yaw, 1;
  return rates;
}

}  // namespace

Eigen::MatrixXd coordinate_rows(const std::vector<Coordinate>& coordinates, const Jacobian& j,
                                const Eigen::Matrix3d& rotation, CoordinateFrame frame) {
  Jacobian resolved = j;
  if (frame == CoordinateFrame::tip) {
    resolved.topRows<3>() = rotation.transpose() * j.topRows<3>();
    resolved.bottomRows<3>() = rotation.transpose() * j.bottomRows<3>();
  }
  Eigen::MatrixXd rows(std::ssize(coordinates), j.cols());
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const Coordinate c = coordinates[i];
    if (!is_euler_angle(c)) {
      rows.row(i) = resolved.row(static_cast<Eigen::Index>(c));
      continue;
    }
    const Eigen::RowVector3d rate = euler_rates(rotation).row(static_cast<Eigen::Index>(c) - 6);
    if (rate.allFinite())
      rows.row(i) = rate * j.bottomRows<3>();
    else
      rows.row(i).setConstant(std::numeric_limits<double>::infinity());
  }
  return rows;
}

Jacobian joint_jacobian(const Chain& chain, const Eigen::VectorXd& q, Eigen::Isometry3d* tip_pose) {
  const auto count = std::ssize(chain.joints);
  Jacobian result(6, count);
  Eigen::Matrix3Xd origins(3, count);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  for (Eigen::Index k = 0; k < count; ++k) {
    const ChainJoint& joint = chain.joints[k];
    const double motion = joint.multiplier * q[joint.coordinate] + joint.offset;
    pose = pose * joint.origin;
    origins.col(k) = pose.translation();
    result.col(k).tail<3>() = pose.linear() * joint.axis;
    if (joint.prismatic)
      pose.translate(motion * joint.axis);
    else
      pose.rotate(Eigen::AngleAxisd(motion, joint.axis));
  }
  pose = pose * chain.tip_offset;
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::Vector3d axis = result.col(k).tail<3>();
    if (chain.joints[k].prismatic) {
      result.col(k) << axis, Eigen::Vector3d::Zero();
    } else {
      const Eigen::Vector3d arm = pose.translation() - origins.col(k);
      result.col(k).head<3>() = axis.cross(arm);
    }
  }
  if (tip_pose) *tip_pose = pose;
  return result;
}

Eigen::MatrixXd to_independent(const Chain& chain, const Eigen::MatrixXd& columns) {
  Eigen::MatrixXd folded = Eigen::MatrixXd::Zero(columns.rows(), std::ssize(chain.independent));
  for (Eigen::Index k = 0; k < columns.cols(); ++k) {
    const ChainJoint& joint = chain.joints[k];
    folded.col(joint.coordinate) += joint.multiplier * columns.col(k);
  }
  return folded;
}

Jacobian jacobian(const Chain& chain, const Eigen::VectorXd& q) {
  return to_independent(chain, joint_jacobian(chain, q));
}

BatchedJacobian::BatchedJacobian(const Chain& chain, InstructionSet set)
    : chain_(fold(chain, false)),
      set_(set),
      scratch_(chain.joints.size() * select_kernels<KinematicKernels>(set).scratch_per_joint) {}

void BatchedJacobian::operator()(const double* q, double* to) {
  std::vector<double> signs;
  for (const FoldedJoint& joint : chain_.joints) signs.push_back(joint.sign);
  select_kernels<KinematicKernels>(set_).jacobians(path_of(chain_), signs.data(), q, to, scratch_.data());
}

}  // namespace qerr
