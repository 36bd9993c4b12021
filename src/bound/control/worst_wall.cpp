#include "bound/control/worst_wall.hpp"

#include <algorithm>
#include <limits>

namespace qerr {

WorstWall worst_wall(const OperationalModel& model, const Wall& wall, const Eigen::MatrixXd& configurations) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  WorstWall r{wall.name, {infinity, infinity, 0, 0}, infinity, infinity, {}};
  const Transmission& t = model.transmission;
  const Eigen::MatrixXd coupling = t.coupling.dense();
  const Eigen::VectorXd widths = widths_at_rest(*model.control, resolutions(t));
  for (Eigen::Index c = 0; c < configurations.cols(); ++c) {
    const Eigen::VectorXd q = configurations.col(c);
    const WallLimit limit = wall_limit(*model.control, felt_by(model.chain, wall, q), coupling, widths);
    r.sampling = std::min(r.sampling, limit.sampling);
    r.quantization = std::min(r.quantization, limit.quantization);
    if (r.at.size() > 0 && limit.stiffness() >= r.limit.stiffness()) continue;
    r.limit = limit;
    r.at = q;
  }
  return r;
}

}  // namespace qerr
