#include "qerr/bound/joint_error.hpp"

namespace qerr {

JointError joint_error(const Transmission& t, const std::vector<IndependentError>& sources,
                       const SignalMoments* along_motion) {
  const auto n = static_cast<Eigen::Index>(t.encoders.size());
  JointError e{Eigen::VectorXd::Zero(n), Eigen::VectorXd::Zero(n), {}, {}};
  Eigen::VectorXd variance = Eigen::VectorXd::Zero(n);
  for (const IndependentError& error : independent_errors(t, sources)) {
    if (error.where == IndependentError::Where::origin) continue;
    const Eigen::VectorXd column = moved_joints(t, error);
    e.mean += column * error.mean;
    e.half_width += column.cwiseAbs() * error.half_width;
    variance += (column * error.sigma).cwiseAbs2();
  }
  if (along_motion) {
    e.half_width += along_motion->peak;
    variance += along_motion->covariance.diagonal();
  }
  e.sigma = variance.cwiseSqrt();
  e.worst_case = e.half_width + e.mean.cwiseAbs();
  return e;
}

}  // namespace qerr
