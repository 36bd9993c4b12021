#include "record_blocks.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace qerr {

std::vector<Eigen::Index> block_starts(const Evidence& e) {
  const Eigen::Index n = e.rows();
  const Eigen::Index least = std::max<Eigen::Index>(std::min<Eigen::Index>(50, n / 4), (n + 127) / 128);
  const Eigen::Index most = std::max(least, n / 8);
  const double revolution = 2 * std::numbers::pi / std::max(std::abs(e.encoder.shaft_ratio), 1e-12);
  std::vector<Eigen::Index> starts{0};
  bool turned = false;
  double travel = 0;
  for (Eigen::Index k = 1; k < n; ++k) {
    turned |= e.side[k] != e.side[k - 1];
    travel += std::abs(e.path[k] - e.path[k - 1]);
    const Eigen::Index length = k - starts.back();
    const bool enough = turned || travel > revolution || length >= most;
    if (length < least || !enough || n - k < least) continue;
    starts.push_back(k);
    turned = false;
    travel = 0;
  }
  return starts;
}

Evidence rows_of(const Evidence& e, const std::vector<Eigen::Index>& rows) {
  Evidence part = e;
  for (Eigen::ArrayXd* column :
       {&part.time, &part.reference, &part.measured, &part.path, &part.velocity, &part.side, &part.joint_path,
        &part.joint_velocity, &part.effort, &part.temperature, &part.chance})
    if (column->size() > 0) *column = Eigen::ArrayXd((*column)(rows));
  return part;
}

Term rows_of(const Term& t, const std::vector<Eigen::Index>& rows) {
  Term part = t;
  part.columns = t.columns(rows, Eigen::all);
  if (t.fixed.size() > 0) part.fixed = Eigen::ArrayXd(t.fixed(rows));
  return part;
}

}  // namespace qerr
