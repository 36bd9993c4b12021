#include "second_order.hpp"

#include <cmath>
#include <limits>
#include <numbers>

namespace qerr {

/// With R_k = |column k| + sum_{m>k} h_m R_m every R_k enters with the weight a_k of its own term and with
/// h_k for every revolute joint before it, times that one's weight.
SecondOrder::SecondOrder(const OperationalModel& model) {
  const Eigen::VectorXd largest = joint_error(model.transmission, model.sources).worst_case;
  position_weights = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(model.chain.joints.size()));
  double before = 0;   // S_{k-1}
  double weights = 0;  // of the revolute joints so far
  double axes = 0;
  for (Eigen::Index k = 0; k < position_weights.size(); ++k) {
    const ChainJoint& joint = model.chain.joints[static_cast<std::size_t>(k)];
    const double h = std::abs(joint.multiplier) * largest[static_cast<Eigen::Index>(joint.coordinate)];
    if (joint.prismatic) {
      position_constant += (before + weights) * h;
      continue;
    }
    const double own = 0.5 * h * (2 * before + h);
    position_weights[k] = own + h * weights;
    weights += position_weights[k];
    axes += 0.5 * h * before;
    before += h;
  }
  rotation_angle = before;
  rotation = before <= std::numbers::pi ? axes + before * before * (0.25 + 0.034 * before)
                                        : std::numeric_limits<double>::infinity();
}

double SecondOrder::position(const Jacobian& joints) const {
  return position_constant + position_weights.dot(joints.topRows<3>().colwise().norm());
}

}  // namespace qerr
