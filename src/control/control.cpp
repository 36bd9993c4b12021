#include "control/control.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "control/loop_response.hpp"

namespace qerr {

WallLimit wall_limit(const Control& control, const Eigen::VectorXd& g, const Eigen::MatrixXd& coupling,
                     const Eigen::VectorXd& widths) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  WallLimit limit{infinity, infinity, 0, 0};
  const double counts = (coupling.transpose() * g).cwiseAbs().dot(widths);
  double delay = 0, largest = -1, yield = 0;  // sum of g_i^2/b_i
  for (Eigen::Index i = 0; i < g.size(); ++i) {
    if (g[i] == 0) continue;
    const auto joint = static_cast<std::size_t>(i);
    const double share = g[i] * g[i] / control.joints[joint].damping.value();
    yield += share;
    delay = std::max(delay, control.samples_of_delay(joint));
    if (share > largest) largest = share, limit.sampling_joint = joint;
    const double stiffness = 2 * control.joints[joint].friction.value() / (std::abs(g[i]) * counts);
    if (stiffness < limit.quantization) limit.quantization = stiffness, limit.quantization_joint = joint;
  }
  if (yield > 0) limit.sampling = 2 * control.sample_rate / ((1 + 2 * delay) * yield);
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

std::vector<ControlFigure> control_figures(const Control& control, const Chain& chain) {
  using Kind = ControlFigure::Kind;
  std::vector<ControlFigure> all;
  for (std::size_t j = 0; j < control.joints.size(); ++j) {
    if (!has_loop(control, chain, j)) continue;
    const std::string loop = "loop." + chain.independent[j].name + '.';
    all.push_back({loop + "gain_margin", Kind::gain_margin, j, dimension::none});
    all.push_back({loop + "phase_margin", Kind::phase_margin, j, dimension::angle});
    all.push_back({loop + "bandwidth", Kind::bandwidth, j, dimension::frequency});
    all.push_back({loop + "limit_cycle", Kind::limit_cycle, j,
                   chain.independent[j].prismatic() ? dimension::length : dimension::angle});
  }
  for (std::size_t j = 0; j < control.joints.size(); ++j)
    if (control.joints[j].kd > 0)
      all.push_back({"control." + chain.independent[j].name + ".kd_max", Kind::largest_kd, j,
                     chain.independent[j].prismatic() ? Dimension{-1, 0, 1, 1} : Dimension{1, -1, 1, 1}});
  for (std::size_t w = 0; w < control.walls.size(); ++w)
    all.push_back({"wall." + control.walls[w].name + ".stiffness", Kind::wall_stiffness, w, {-1, 0, 0, 1}});
  return all;
}

}  // namespace qerr
