#include "theory_along_path.hpp"

#include <algorithm>
#include <cmath>

#include "qerr/core/error.hpp"
#include "qerr/simulate/noise_along_motion.hpp"

namespace qerr {

namespace {

constexpr std::uint64_t most_points = 20000;

/// The square of each encoder's share in a coordinate, averaged along the path, and the largest rigorous
/// bound.
struct Along {
  Eigen::MatrixXd squares;  // coordinates x encoders, (J C Delta)^2
  Eigen::VectorXd rigorous;
};

Along along(const OperationalModel& model, const Motion& motion, std::uint64_t samples,
            std::uint64_t settling) {
  const MotionPath path(motion);
  const auto m = static_cast<Eigen::Index>(model.coordinates.size());
  Along a{Eigen::MatrixXd::Zero(m, static_cast<Eigen::Index>(model.transmission.encoders.size())),
          Eigen::VectorXd::Zero(m)};
  const std::uint64_t step = 1 + samples / most_points;
  double counted = 0;
  for (std::uint64_t k = 0; k < samples; k += step) {
    const OperationalError e =
        operational_error(model, path.position(static_cast<double>(k) / motion.sample_rate));
    // A filter remembers what was before the statistics began.
    a.rigorous = a.rigorous.cwiseMax(e.rigorous);
    if (k < settling) continue;
    a.squares += e.weighted.cwiseAbs2();
    counted += 1;
  }
  if (counted > 0) a.squares /= counted;
  return a;
}

}  // namespace

TheoryAlongPath::TheoryAlongPath(const OperationalModel& model, const std::vector<Filter>& filters,
                                 const std::vector<Norms>& norms, const Motion& motion, std::uint64_t samples,
                                 std::uint64_t settling) {
  const OperationalError middle = operational_error(model, center(motion));
  const Along path = along(model, motion, samples, settling);
  const auto encoders = static_cast<Eigen::Index>(model.transmission.encoders.size());
  const double start = static_cast<double>(settling) / motion.sample_rate;
  for (std::size_t f = 0; f <= filters.size(); ++f) {
    Norms n;
    n.h2 = n.dc_gain = n.l1.lower = n.l1.upper = 1;
    if (f > 0) n = norms[f - 1];
    Eigen::VectorXd noise = Eigen::VectorXd::Constant(encoders, n.h2 / std::sqrt(12.0));
    if (f > 0)
      noise = noise_along_motion(model.transmission, motion, autocorrelation(filters[f - 1]),
                                 filters[f - 1].sample_rate, start);
    auto& row = signals_.emplace_back();
    for (Eigen::Index c = 0; c < middle.sigma.size(); ++c) {
      const Bounds b = derivative_error(middle.half_width[c], middle.mean[c], middle.sigma[c], n);
      row.push_back({b.sigma, n.h2 * std::sqrt(path.squares.row(c).sum() / 12),
                     std::sqrt(path.squares.row(c).dot(noise.cwiseAbs2().transpose())), b.worst_case,
                     n.l1.upper * path.rigorous[c]});
    }
  }
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
