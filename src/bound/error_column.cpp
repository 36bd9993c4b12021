#include "bound/error_column.hpp"

namespace qerr {

namespace {

/// Rotation of the parent link's frame of a joint of the chain in the base frame.
Eigen::Matrix3d parent_axes(const Chain& chain, const Eigen::VectorXd& q, std::size_t link) {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  for (std::size_t k = 0; k < link; ++k) {
    const ChainJoint& joint = chain.joints[k];
    axes = axes * joint.origin.linear();
    if (joint.prismatic) continue;
    const double angle = joint.multiplier * q[static_cast<Eigen::Index>(joint.coordinate)] + joint.offset;
    axes = axes * Eigen::AngleAxisd(angle, joint.axis);
  }
  return axes * chain.joints[link].parent_axes;
}

}  // namespace

Eigen::VectorXd error_column(const IndependentError& s, const OperationalModel& model,
                             const Eigen::VectorXd& q, const Eigen::Matrix3d& rotation,
                             const Eigen::MatrixXd& joint_rows, const Eigen::MatrixXd& encoder_rows) {
  const auto i = static_cast<Eigen::Index>(s.owner);
  if (s.where == IndependentError::Where::joint) return joint_rows.col(i);
  if (s.where == IndependentError::Where::encoder) return encoder_rows.col(i);
  Eigen::Vector3d shift = parent_axes(model.chain, q, s.link) * s.direction;
  if (model.frame == CoordinateFrame::tip) shift = rotation.transpose() * shift;
  Eigen::VectorXd column = Eigen::VectorXd::Zero(joint_rows.rows());
  for (std::size_t k = 0; k < model.coordinates.size(); ++k) {
    const auto c = static_cast<Eigen::Index>(k);
    const Coordinate coordinate = model.coordinates[k];
    if (is_position(coordinate)) column[c] = shift[static_cast<Eigen::Index>(coordinate)];
  }
  return column;
}

}  // namespace qerr
