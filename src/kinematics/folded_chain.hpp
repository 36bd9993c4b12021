#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "kinematics/kernels.hpp"
#include "qerr/kinematics/chain.hpp"

namespace qerr {

/// A chain with its constants precomputed, for forward kinematics in few operations (see FoldedJoint).
struct FoldedChain {
  std::vector<FoldedJoint> joints;
  /// Axes before the first joint's rotation (columns X, Y', Z') and a point on its axis, in the base frame.
  Eigen::Matrix3d first_axes = Eigen::Matrix3d::Identity();
  Eigen::Vector3d first_point = Eigen::Vector3d::Zero();
  double axes_length = 1;       ///< of X, Y, Z (scale_axes)
  double tip_x = 0, tip_y = 0;  ///< tip = o + tip_x X + tip_y Y behind the last joint [m]
  /// Rotation of the tip: R = [X Y Z] tip_axes with the axes behind the last joint.
  Eigen::Matrix3d tip_axes = Eigen::Matrix3d::Identity();
  /// [k]: maps directions in the chain's frame behind moving joint k to [X Y Z] behind its rotation.
  std::vector<Eigen::Matrix3d> link_axes;
};

/// View for the batched kernels. @pre the chain outlives it
FoldedPath path_of(const FoldedChain&);

/// Sets the motion of a joint to multiplier q + offset [rad or m].
void set_motion(FoldedJoint&, double multiplier, double offset);

/// Scales the axes X, Y, Z to a length; points stay the same. If all columns of a Jacobian have the same
/// factor, axes of that length make its products unnecessary.
void scale_axes(FoldedChain&, double length);

/// Folds the fixed transforms of a chain, in long double.
///
/// Joint frames are rotated about and translated along their axes, which changes neither the axes nor the
/// tip, so that most constants are 0. Only angles within 1e-15 of a multiple of a right angle are taken as
/// exact: the URDF's 1.5708 is not. The common normal of nearly parallel axes is far away; frames are not
/// translated to it.
/// @param orientation  whether the tip's rotation is needed; if not, a last joint through the tip does not
/// rotate
FoldedChain fold(const Chain&, bool orientation);

}  // namespace qerr
