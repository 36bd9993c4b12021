#include "simulate/theory_along_path.hpp"

#include <cmath>

#include "simulate/motion_path.hpp"

namespace qerr {

void BoundsAlongPath::include(const BoundsAlongPath& other) {
  rigorous = rigorous.cwiseMax(other.rigorous);
  deviation = deviation.cwiseMax(other.deviation);
}

std::vector<std::vector<SignalTheory>> theory_along_path(const OperationalError& middle,
                                                         const std::vector<Norms>& norms,
                                                         const Eigen::VectorXd& squares,
                                                         const BoundsAlongPath& bounds) {
  std::vector<std::vector<SignalTheory>> all;
  for (std::size_t f = 0; f <= norms.size(); ++f) {
    Norms n;
    n.h2 = n.dc_gain = n.l1.lower = n.l1.upper = 1;
    if (f > 0) n = norms[f - 1];
    auto& row = all.emplace_back();
    for (Eigen::Index c = 0; c < middle.sigma.size(); ++c) {
      const Bounds b = derivative_error(middle.half_width[c], middle.mean[c], middle.sigma[c], n);
      row.push_back({n.h2 * middle.weighted.row(c).norm() / std::sqrt(12.0),
                     n.h2 * std::sqrt(squares[c] / 12), b.worst_case,
                     f == 0 ? bounds.rigorous[c]
                            : n.l1.upper * bounds.deviation[c] + std::abs(n.dc_gain * middle.mean[c])});
    }
  }
  return all;
}

Eigen::VectorXd center(const Motion& motion) {
  const MotionPath path(motion);
  Eigen::VectorXd middle(static_cast<Eigen::Index>(path.joints()));
  Eigen::MatrixX2d range;
  for (std::size_t i = 0; i < path.joints(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    if (!motion.joints.empty() && motion.joints[i].moves.empty()) {
      middle[row] = motion.joints[i].center + 0.5 * motion.joints[i].velocity * motion.duration;
      continue;
    }
    if (range.rows() == 0) range = extent(motion);
    middle[row] = range.row(row).mean();
  }
  return middle;
}

}  // namespace qerr
