#include "simulate/theory_along_path.hpp"

#include <cmath>
#include <limits>

#include "simulate/motion_path.hpp"
#include "simulate/noise_along_motion.hpp"

namespace qerr {

AlongPath::AlongPath(Eigen::Index coordinates, Eigen::Index encoders, std::size_t stretches)
    : encoders_(encoders),
      squares_(Eigen::MatrixXd::Zero(coordinates * encoders + most_lanes - 1,
                                     static_cast<Eigen::Index>(stretches))),
      rigorous_(Eigen::VectorXd::Zero(coordinates)),
      deviation_(rigorous_) {}

void AlongPath::bound_by(const Eigen::VectorXd& rigorous, const Eigen::VectorXd& deviation) {
  rigorous_ = rigorous_.cwiseMax(rigorous);
  deviation_ = deviation_.cwiseMax(deviation);
}

void AlongPath::append(const AlongPath& later) {
  counted_ += later.counted_;
  squares_ += later.squares_;
  rigorous_ = rigorous_.cwiseMax(later.rigorous_);
  deviation_ = deviation_.cwiseMax(later.deviation_);
}

Eigen::MatrixXd AlongPath::mean_squares() const { return mean_squares(Eigen::MatrixXd::Ones(1, encoders_)); }

Eigen::MatrixXd AlongPath::mean_squares(const Eigen::MatrixXd& weights) const {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(rigorous_.size(), encoders_);
  for (Eigen::Index s = 0; s < squares_.cols(); ++s) {
    const Eigen::Index row = s * weights.rows() / squares_.cols();
    sum += squares_.col(s).head(sum.size()).reshaped(sum.rows(), sum.cols()) * weights.row(row).asDiagonal();
  }
  return counted_ > 0 ? Eigen::MatrixXd(sum / counted_) : sum;
}

namespace {

/// Contribution of every encoder to the variance of every coordinate after a filter, from the speeds along
/// the path; NaN if the memory of the filter is too long.
Eigen::MatrixXd exact_variance(const AlongPath& path, const Transmission& transmission, const Motion& motion,
                               const Filter& filter, double start) {
  const auto memory = autocorrelation_within(filter);
  const auto encoders = static_cast<Eigen::Index>(transmission.encoders.size());
  if (!memory)
    return Eigen::MatrixXd::Constant(path.rigorous().size(), encoders,
                                     std::numeric_limits<double>::quiet_NaN());
  return path.mean_squares(
      noise_power_along_motion(transmission, motion, *memory, filter.sample_rate, start, path.stretches()));
}

}  // namespace

std::vector<std::vector<SignalTheory>> theory_along_path(
    const OperationalError& middle, const Transmission& transmission, const std::vector<Filter>& filters,
    const std::vector<Norms>& norms, const Motion& motion, std::uint64_t settling, const AlongPath& path) {
  const Eigen::MatrixXd squares = path.mean_squares();
  const double start = static_cast<double>(settling) / motion.sample_rate;
  std::vector<std::vector<SignalTheory>> all;
  for (std::size_t f = 0; f <= filters.size(); ++f) {
    Norms n;
    n.h2 = n.dc_gain = n.l1.lower = n.l1.upper = 1;
    if (f > 0) n = norms[f - 1];
    const Eigen::MatrixXd exact = f == 0 ? Eigen::MatrixXd(squares / 12)
                                         : exact_variance(path, transmission, motion, filters[f - 1], start);
    auto& row = all.emplace_back();
    for (Eigen::Index c = 0; c < middle.sigma.size(); ++c) {
      const Bounds b = derivative_error(middle.half_width[c], middle.mean[c], middle.sigma[c], n);
      // Infinite if the path meets the gimbal lock, even where the power of an encoder at rest is 0.
      const double ipqn_path = n.h2 * std::sqrt(squares.row(c).sum() / 12);
      row.push_back({n.h2 * middle.weighted.row(c).norm() / std::sqrt(12.0), ipqn_path,
                     std::isfinite(ipqn_path) ? std::sqrt(exact.row(c).sum()) : ipqn_path, b.worst_case,
                     f == 0 ? path.rigorous()[c]
                            : n.l1.upper * path.deviation()[c] + std::abs(n.dc_gain * middle.mean[c])});
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
