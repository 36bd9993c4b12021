#pragma once

#include <Eigen/Core>
#include <string>

#include "control/walls.hpp"
#include "qerr/bound/operational_error.hpp"

namespace qerr {

/// A wall: the least limit over the configurations, and where it is.
struct WorstWall {
  std::string name;
  WallLimit limit;
  double sampling = 0, quantization = 0;  ///< the least of either condition [N/m]
  Eigen::VectorXd at;
};

/// @param configurations  joints x configurations
/// @pre damping and friction of all joints are stated
WorstWall worst_wall(const OperationalModel&, const Wall&, const Eigen::MatrixXd& configurations);

}  // namespace qerr
