#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "kinematics/folded_path.hpp"
#include "qerr/kinematics/chain.hpp"

namespace qerr {

/// A chain with all that is constant worked out beforehand: for a walk from base to tip by few operations.
struct FoldedChain {
  std::vector<FoldedJoint> joints;
  /// Axes before the first joint's turn (columns X, Y', Z') and a point on its axis, in the base frame.
  Eigen::Matrix3d first_axes = Eigen::Matrix3d::Identity();
  Eigen::Vector3d first_point = Eigen::Vector3d::Zero();
  double axes_length = 1;       ///< of X, Y, Z: lengths along them count in it (stretch_axes)
  bool upright = false;         ///< first_axes is a multiple of the identity
  double tip_x = 0, tip_y = 0;  ///< tip = o + tip_x X + tip_y Y behind the last joint [m]
  /// Rotation of the tip: R = [X Y Z] tip_axes with the axes behind the last joint.
  Eigen::Matrix3d tip_axes = Eigen::Matrix3d::Identity();
  /// [k]: a direction of the frame behind moving joint k as the chain has it, in [X Y Z] behind its turn.
  std::vector<Eigen::Matrix3d> link_axes;
};

/// What the batched kernels take. @pre the chain outlives the path
FoldedPath path_of(const FoldedChain&);

/// Lets a joint turn or slide by multiplier q + offset [rad or m].
void move_by(FoldedJoint&, double multiplier, double offset);

/// Makes the axes X, Y, Z so long; points stay where they are. Where all columns of a Jacobian are wanted
/// times the same factor, a walk along axes of that length needs no products for it.
void stretch_axes(FoldedChain&, double length);

/// Folds the fixed transforms of a chain, in long double.
///
/// Joint frames are turned about and slid along their axes, which changes neither the axes nor the tip, so
/// that most numbers vanish. Angles within 1e-15 of right or straight ones are taken as such and no others:
/// the URDF's 1.5708 stays what it is. Where axes are nearly parallel their common normal lies far away, and
/// frames are not slid to it.
/// @param orientation  whether the tip's rotation is asked for; if not, the last joint need not turn a tip
/// on its axis
FoldedChain fold(const Chain&, bool orientation);

}  // namespace qerr
