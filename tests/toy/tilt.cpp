#include <cmath>
#include <limits>

#include "bound/signals/signals.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/kinematics/chain.hpp"

namespace qerr {

/// The angle between the z axes of the base and of the tip, acos(z . t): d/dq_j = -z . (w_j x t) /
/// sin(angle).
SignalKind tilt_signal() {
  return {.group = "tilts",
          .summary = "angle between the z axes of base and tip",
          .signals =
              [](const OperationalModel&) {
                return std::vector<Signal>{{"tilt", "rad"}};
              },
          .row =
              [](const OperationalModel& model, std::size_t, const Eigen::VectorXd& q) {
                Eigen::Isometry3d pose;
                const Jacobian j = joint_jacobian(model.chain, q, &pose);
                const Eigen::Vector3d tip = pose.linear().col(2);
                const double sine = std::hypot(tip.x(), tip.y());
                Eigen::MatrixXd row(1, j.cols());
                for (Eigen::Index k = 0; k < j.cols(); ++k)
                  row(0, k) = -j.col(k).tail<3>().cross(tip).z() / sine;
                return Eigen::RowVectorXd(to_independent(model.chain, row));
              },
          .remainder = [](const OperationalModel&, std::size_t, const Eigen::VectorXd&,
                          const Eigen::VectorXd&) { return std::numeric_limits<double>::infinity(); }};
}

}  // namespace qerr
