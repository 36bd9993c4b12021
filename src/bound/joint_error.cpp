#include "qerr/bound/joint_error.hpp"

#include <cmath>

namespace qerr {

JointError joint_error(const Transmission& t) {
  const Eigen::VectorXd delta = resolutions(t);
  JointError e;
  e.mean = t.coupling * mean_errors(t);
  e.half_width = 0.5 * t.coupling.cwiseAbs() * delta;
  e.worst_case = e.half_width + e.mean.cwiseAbs();
  e.sigma = (t.coupling * delta.asDiagonal()).rowwise().norm() / std::sqrt(12.0);
  return e;
}

}  // namespace qerr
