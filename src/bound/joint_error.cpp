#include "qerr/bound/joint_error.hpp"

#include <cmath>

namespace qerr {

namespace {

Eigen::VectorXd joint_sigma(const Coupling& coupling, const Eigen::VectorXd& delta) {
  if (coupling.is_identity()) return delta / std::sqrt(12.0);
  return (coupling.dense() * delta.asDiagonal()).rowwise().norm() / std::sqrt(12.0);
}

}  // namespace

JointError joint_error(const Transmission& t, const std::vector<ErrorSource>& sources,
                       const SignalMoments* along_motion) {
  const Eigen::VectorXd delta = resolutions(t);
  JointError e;
  e.mean = t.coupling * mean_errors(t);
  e.half_width = 0.5 * (t.coupling.magnitudes() * delta);
  e.sigma = joint_sigma(t.coupling, delta);
  for (const ErrorSource& s : sources) {
    if (s.where == ErrorSource::Where::origin) continue;
    const auto i = static_cast<Eigen::Index>(s.owner);
    const Eigen::VectorXd column = s.where == ErrorSource::Where::encoder
                                       ? Eigen::VectorXd(t.coupling.col(i))
                                       : Eigen::VectorXd(Eigen::VectorXd::Unit(delta.size(), i));
    e.mean += column * s.mean;
    e.half_width += column.cwiseAbs() * s.half_width;
    e.sigma = (e.sigma.array().square() + (column * s.sigma).array().square()).sqrt();
  }
  if (along_motion) {
    e.half_width += along_motion->peak;
    e.sigma = (e.sigma.array().square() + along_motion->covariance.diagonal().array()).sqrt();
  }
  e.worst_case = e.half_width + e.mean.cwiseAbs();
  return e;
}

}  // namespace qerr
