#include "bound/linearization_remainder.hpp"

#include <cmath>
#include <limits>
#include <numbers>

namespace qerr {

LinearizationRemainder linearization_remainder(const Chain& chain, const Eigen::VectorXd& largest) {
  LinearizationRemainder r;
  r.per_column = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(chain.joints.size()));
  double before = 0;   // S_{k-1}
  double carried = 0;  // sum_{i<k} per_column_i: R_i grows by h_k (R_k or 1)
  double axes = 0;     // sum_k h_k S_{k-1} / 2
  for (Eigen::Index k = 0; k < r.per_column.size(); ++k) {
    const ChainJoint& joint = chain.joints[static_cast<std::size_t>(k)];
    const double h = std::abs(joint.multiplier) * largest[static_cast<Eigen::Index>(joint.coordinate)];
    if (joint.prismatic) {
      r.position += (before + carried) * h;
      continue;
    }
    r.per_column[k] = h * (before + 0.5 * h + carried);
    carried += r.per_column[k];
    axes += 0.5 * h * before;
    before += h;
  }
  r.rotation_angle = before;
  r.rotation = before <= std::numbers::pi ? axes + before * before * (0.25 + 0.034 * before)
                                          : std::numeric_limits<double>::infinity();
  return r;
}

}  // namespace qerr
