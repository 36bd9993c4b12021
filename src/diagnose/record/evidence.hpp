#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "qerr/bound/operational_error.hpp"
#include "qerr/simulate/log.hpp"

namespace qerr {

/// What a log tells of one encoder, in the encoder's coordinate (at the joint's side of its gear): the
/// position by the better sensor beside what was measured.
struct Evidence {
  std::string joint;        ///< whose encoder it is
  Eigen::Index number = 0;  ///< of the encoder
  bool prismatic = false;
  Encoder encoder;
  bool ordered = true;       ///< the rows follow each other in time
  Eigen::ArrayXd time;       ///< from the first row [s]; the row's number where there is none
  Eigen::ArrayXd reference;  ///< by the better sensor [rad or m]
  Eigen::ArrayXd measured;   ///< as read [rad or m]
  Eigen::ArrayXd path;       ///< the reference without its noise [rad or m]
  Eigen::ArrayXd velocity;   ///< of the path [rad/s or m/s]
  Eigen::ArrayXd direction;  ///< of the joint's last motion: -1, +1, or 0 before the first
  /// The joint's own angle and velocity, where its encoder feels other joints too (coupling); else empty.
  Eigen::ArrayXd joint_path, joint_velocity;
  Eigen::ArrayXd effort;        ///< empty where it is not known
  Eigen::ArrayXd temperature;   ///< rise since the start [K]; empty where it is not known
  Eigen::ArrayXd random_sigma;  ///< standard deviation of the random effects that the spec has; empty: none
  double noise = 0;             ///< standard deviation of the reference's own noise [rad or m]
  double path_noise = 0;        ///< what is left of it in the path [rad or m]
  double log_resolution = 0;    ///< step of the reference as it is written in the file [rad or m]
  bool counted = true;          ///< measured are whole counts
  /// Rows that say together what one independent reading would: above 1 where what is left of them by any
  /// model is correlated, as in a table that was interpolated between fewer points.
  double rows_per_reading = 1;

  Eigen::Index rows() const { return reference.size(); }
  /// Of the joint: what clock, link and gear act on.
  const Eigen::ArrayXd& joint_angle() const { return joint_path.size() > 0 ? joint_path : path; }
  const Eigen::ArrayXd& joint_rate() const { return joint_velocity.size() > 0 ? joint_velocity : velocity; }
  /// Whether the encoder has moved by no more than a few counts: no place, no speed and no order can be told.
  bool is_stationary() const { return path.maxCoeff() - path.minCoeff() < 8 * step(); }
  bool coupled() const { return joint_path.size() > 0; }
  double step() const { return encoder.resolution; }
  double independent_readings() const {
    return static_cast<double>(rows()) / rows_per_reading;
  }  ///< independent ones
};

/// Rows that say the same, [first, end).
struct RowGroup {
  Eigen::Index first, end;
};

/// Rows of a record that say different things. As long as a joint rests, its reading and its true position
/// stay what they are, and only the reference's noise changes: taken for independent readings such rows would
/// make certainty out of one coincidence.
/// @param most  where there are more groups, one is drawn from every so many: the record's length is no
///   reason for a fit to take longer
std::vector<RowGroup> independent_rows(const Evidence&, Eigen::Index most = 16384);

/// The same evidence with the mean of each group in place of its rows.
Evidence group_means(const Evidence&, const std::vector<RowGroup>&);

/// The evidence of every encoder whose joints have a reference.
/// @param log  with its values
std::vector<Evidence> evidence(const OperationalModel&, const Log& log, unsigned threads = 0);

}  // namespace qerr
