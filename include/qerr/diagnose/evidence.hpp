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
  std::string joint;  ///< whose encoder it is
  bool prismatic = false;
  Encoder encoder;
  bool ordered = true;         ///< the rows follow each other in time
  Eigen::ArrayXd time;         ///< from the first row [s]; the row's number where there is none
  Eigen::ArrayXd reference;    ///< by the better sensor [rad or m]
  Eigen::ArrayXd measured;     ///< as read [rad or m]
  Eigen::ArrayXd path;         ///< the reference without its noise [rad or m]
  Eigen::ArrayXd velocity;     ///< of the path [rad/s or m/s]
  Eigen::ArrayXd side;         ///< of the last motion: -1, +1, or 0 before the first
  Eigen::ArrayXd effort;       ///< empty where it is not known
  Eigen::ArrayXd temperature;  ///< rise since the start [K]; empty where it is not known
  double noise = 0;            ///< standard deviation of the reference's own noise [rad or m]
  double grid = 0;             ///< step of the reference as it is written in the file [rad or m]
  bool counted = true;         ///< measured are whole counts

  Eigen::Index rows() const { return reference.size(); }
  double step() const { return encoder.resolution; }
};

/// The same with one row in place of many that say the same: as long as a joint rests, its reading and its
/// true position stay what they are, and only the reference's noise changes. Taken for independent readings
/// they would make certainty out of one coincidence.
/// @param starts  where each one's rows begin, as independent_rows says
Evidence independent(const Evidence&, const std::vector<Eigen::Index>& starts);
Evidence independent(const Evidence&);

/// First rows of groups that say the same.
std::vector<Eigen::Index> independent_rows(const Evidence&);

/// The evidence of every encoder whose joints have a reference.
/// @param log  with its values
std::vector<Evidence> evidence(const OperationalModel&, const Log& log);

}  // namespace qerr
