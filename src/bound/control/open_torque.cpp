#include "bound/control/open_torque.hpp"

#include <algorithm>
#include <cmath>

#include "control/loop_response.hpp"
#include "qerr/bound/independent_error.hpp"

namespace qerr {

/// The largest kd at which the torque keeps a limit; 0 if none does.
///
/// ||kp + kd H||_1 h + |kp + kd H(1)| |m| and ||kp + kd H||_2 sigma are convex in kd, so that below the
/// largest one there is a single crossing.
double largest_kd(const OperationalModel& model, std::size_t joint, Bound bound, double limit) {
  const JointController& c = model.control->joints[joint];
  const ResponseSums sums = response_sums(c.velocity_filter);
  const JointError error = joint_error(model);
  const auto j = static_cast<Eigen::Index>(joint);
  const auto met = [&](double kd) {
    const double torque = bound == Bound::worst_case
                              ? sums.l1(c.kp, kd) * error.half_width[j] +
                                    std::abs(c.kp + kd * sums.dc) * std::abs(error.mean[j])
                              : sums.h2(c.kp, kd) * error.sigma[j];
    return torque <= limit;
  };
  double lower = met(c.kd) ? c.kd : 0;
  if (!met(lower)) return 0;
  double upper = c.kd;
  for (int i = 0; i < 1000 && met(upper); ++i) upper *= 2;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (lower + upper);
    (met(middle) ? lower : upper) = middle;
  }
  return lower;
}

namespace {

/// ||kp + kd H||_1 of the joint's own controller, or of each pair of joints of an impedance at the tip:
/// errors of joint j in the torque of a joint.
Eigen::RowVectorXd torque_norms(const OperationalModel& model, std::size_t joint, const Eigen::VectorXd& q,
                                const Eigen::MatrixXd& moved, const std::vector<ResponseSums>& sums) {
  const Control& control = *model.control;
  const auto row = static_cast<Eigen::Index>(joint);
  if (!control.tip)
    return moved.row(row).cwiseAbs() * sums[joint].l1(control.joints[joint].kp, control.joints[joint].kd);
  const Eigen::MatrixXd j = jacobian(model.chain, q).topRows<3>();
  const Eigen::RowVectorXd k = j.col(row).transpose() * control.tip->stiffness.asDiagonal() * j * moved,
                           d = j.col(row).transpose() * control.tip->damping.asDiagonal() * j * moved;
  Eigen::RowVectorXd norms(moved.cols());
  for (Eigen::Index e = 0; e < norms.size(); ++e) norms[e] = control.tip->velocity_sums.l1(k[e], d[e]);
  return norms;
}

}  // namespace

/// The torques due to errors within their half widths; means are left out.
std::vector<OpenTorque> open_torques(const OperationalModel& model, const Eigen::MatrixXd& configurations) {
  const Control& control = *model.control;
  const Transmission& t = model.transmission;
  const auto& joints = model.chain.independent;
  std::vector<IndependentError> errors = independent_errors(model);
  std::erase_if(errors, [](const auto& e) { return e.where == IndependentError::Where::origin; });
  Eigen::MatrixXd moved(static_cast<Eigen::Index>(joints.size()), static_cast<Eigen::Index>(errors.size()));
  for (Eigen::Index e = 0; e < moved.cols(); ++e)
    moved.col(e) = moved_joints(t, errors[static_cast<std::size_t>(e)]);
  std::vector<ResponseSums> sums(joints.size());
  for (std::size_t j = 0; j < joints.size(); ++j)
    if (control.joints[j].kd > 0) sums[j] = response_sums(control.joints[j].velocity_filter);
  std::vector<OpenTorque> all;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    if (!control.tip && !control.joints[j].acts()) continue;
    OpenTorque r{j, 0, {}, Eigen::VectorXd::Zero(static_cast<Eigen::Index>(joints.size()))};
    const Eigen::Index count = control.tip ? configurations.cols() : 1;
    for (Eigen::Index c = 0; c < count; ++c) {
      const Eigen::RowVectorXd norms = torque_norms(model, j, configurations.col(c), moved, sums);
      Eigen::VectorXd parts = Eigen::VectorXd::Zero(r.share.size());
      for (Eigen::Index e = 0; e < norms.size(); ++e) {
        const IndependentError& error = errors[static_cast<std::size_t>(e)];
        parts[static_cast<Eigen::Index>(error.owner)] += std::abs(norms[e]) * error.half_width;
      }
      if (!(parts.sum() > 0)) continue;
      r.worst_case = std::max(r.worst_case, parts.sum());
      r.share += parts / parts.sum() / static_cast<double>(count);
    }
    if (const auto& limit = joints[j].effort_limit; limit && *limit > 0) r.relative = r.worst_case / *limit;
    all.push_back(std::move(r));
  }
  return all;
}

}  // namespace qerr
