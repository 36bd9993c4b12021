#pragma once

#include <Eigen/Core>
#include <string>

#include "qerr/encoder/encoder.hpp"

namespace qerr {

/// Signals of one encoder's record from which regressors of effects are computed, row by row, in the
/// encoder's coordinate (at the joint's side of its gear).
struct RecordSignals {
  std::string joint;  ///< whose encoder it is
  bool prismatic = false;
  Encoder encoder;
  bool ordered = true;          ///< the rows follow each other in time
  bool counted = true;          ///< readings are whole counts
  bool loaded = true;           ///< the joint's own weight can load it
  Eigen::ArrayXd time;          ///< from the first row [s]; the row's number if the record has no time
  Eigen::ArrayXd path;          ///< the reference without its noise [rad or m]
  Eigen::ArrayXd velocity;      ///< of the path [rad/s or m/s]
  Eigen::ArrayXd acceleration;  ///< of the joint's own path [rad/s^2 or m/s^2]; empty where it is not known
  Eigen::ArrayXd direction;     ///< direction of the joint's last motion: -1, +1, or 0 before the first
  /// The joint's own position and velocity where its encoder measures other joints too (coupling); else
  /// empty.
  Eigen::ArrayXd joint_path, joint_velocity;
  Eigen::ArrayXd effort;       ///< [N m or N]; empty where it is not known
  Eigen::ArrayXd temperature;  ///< rise since the start [K]; empty where it is not known

  Eigen::Index rows() const { return path.size(); }
  double step() const { return encoder.resolution; }
  /// Of the joint: what clock, link and gear act on.
  const Eigen::ArrayXd& joint_angle() const { return joint_path.size() > 0 ? joint_path : path; }
  const Eigen::ArrayXd& joint_rate() const { return joint_velocity.size() > 0 ? joint_velocity : velocity; }
  bool coupled() const { return joint_path.size() > 0; }
  double range() const { return path.maxCoeff() - path.minCoeff(); }  ///< of the path [rad or m]
  /// Whether the encoder moves by less than 8 counts (convention): effects of position and speed are then not
  /// identifiable.
  bool is_stationary() const { return range() < 8 * step(); }
};

}  // namespace qerr
