#include "control/walls.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "qerr/kinematics/chain.hpp"

namespace qerr {

WallLimit wall_limit(const Control& control, const Eigen::VectorXd& g, const Eigen::MatrixXd& coupling,
                     const Eigen::VectorXd& resolutions) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  WallLimit limit{infinity, infinity, 0, 0};
  const double counts = (coupling.transpose() * g).cwiseAbs().dot(resolutions);
  double yield = 0, largest = -1;  // sum of g_i^2/b_i
  for (Eigen::Index i = 0; i < g.size(); ++i) {
    if (g[i] == 0) continue;
    const auto joint = static_cast<std::size_t>(i);
    const double share = g[i] * g[i] / control.joints[joint].damping.value();
    yield += share;
    if (share > largest) largest = share, limit.sampling_joint = joint;
    const double stiffness = 2 * control.joints[joint].friction.value() / (std::abs(g[i]) * counts);
    if (stiffness < limit.quantization) limit.quantization = stiffness, limit.quantization_joint = joint;
  }
  if (yield > 0) limit.sampling = 2 * control.sample_rate / ((1 + 2 * control.samples_of_delay()) * yield);
  return limit;
}

Eigen::VectorXd felt_by(const Chain& chain, const Wall& wall, const Eigen::VectorXd& q) {
  const Eigen::VectorXd g = jacobian(chain, q).topRows<3>().transpose() * wall.normal;
  return (g.array().abs() > 1e-12 * g.cwiseAbs().maxCoeff()).select(g, 0.0);
}

std::string missing_for_walls(const Control& control, const Chain& chain) {
  std::string missing;
  const auto add = [&](const char* what, const std::string& joint) {
    missing += (missing.empty() ? "" : ", ") + (what + (" of " + joint));
  };
  for (std::size_t j = 0; j < control.joints.size(); ++j) {
    if (!control.joints[j].damping) add("damping", chain.independent[j].name);
    if (!control.joints[j].friction) add("friction", chain.independent[j].name);
  }
  return missing;
}

}  // namespace qerr
