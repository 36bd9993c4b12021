#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "diagnose/inference/tip/tip_evidence.hpp"
#include "effect/term.hpp"

namespace qerr {

/// Where everything is at one row: what columns of terms at the tip are made of. Base frame, [m].
struct TipPose {
  Eigen::Matrix3Xd origin, axis;        ///< of the moving joints
  std::vector<Eigen::Matrix3d> parent;  ///< axes of the frame in which each joint's origin is stated
  Eigen::Matrix3d tool;                 ///< axes of the tip
  Eigen::Vector3d tip;
  Eigen::Matrix3Xd encoders;  ///< tip per encoder, J C: only of joints that have no better sensor
  Eigen::Matrix3Xd joints;    ///< tip per independent joint, J
};

/// The robot as it is believed: links as built, encoders as corrected, and the tracker's frames.
struct TipBelief {
  Chain chain;
  Eigen::MatrixXd additions;  ///< encoders x rows: what causes have added to the readings [rad or m]
  Eigen::Isometry3d base = Eigen::Isometry3d::Identity();  ///< of the robot in the tracker's frame
  Eigen::Vector3d tool = Eigen::Vector3d::Zero();  ///< the target, in the frame of the model's tip [m]

  TipPose pose(const TipEvidence&, Eigen::Index row) const;
};

/// A cause that moves the tip away from where the model believes it.
struct TipTerm {
  enum class Way {
    encoder,   ///< adds `series` to what an encoder reads
    geometry,  ///< displaces a joint's origin along `direction`, an axis of its parent link's frame
    tilt,      ///< turns a joint's axis about the two axes across it
    base,      ///< moves and turns the robot in the tracker's frame
    tool       ///< moves the target in the tip's frame
  };
  Way way = Way::encoder;
  Term term;              ///< its effect and fill; of an encoder's the columns too
  std::size_t where = 0;  ///< encoder or moving joint
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< of geometry, in its parent link's axes
  bool kinematic() const {  ///< whether it is a matter of dimensions, not of motion
    return way != Way::encoder || term.constant;
  }
  Eigen::Index size() const;

  /// estimate - true at the tip per unit of the coefficients, 3 x size.
  Eigen::Matrix3Xd at(const TipPose&, Eigen::Index row) const;
};

/// Every cause of the catalogue that the tip can show: dimensions, and what encoders without a better sensor
/// add.
std::vector<TipTerm> tip_terms(const TipEvidence&, const TipBelief&);

/// The tilt of every joint's axis; has no name in the catalogue.
std::vector<TipTerm> tilt_terms(const Chain&);

/// An encoder's evidence with the path that it went when the believed additions are taken off.
Evidence believed(const TipEvidence&, const TipBelief&, std::size_t encoder);

/// The same cause with its columns along the believed path; of a backlash with the play of the gap found.
void renew(TipTerm&, const Eigen::VectorXd& coefficients, const TipEvidence&, const TipBelief&);

}  // namespace qerr
