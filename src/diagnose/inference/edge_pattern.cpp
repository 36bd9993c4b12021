#include "diagnose/inference/edge_pattern.hpp"

#include <algorithm>
#include <cmath>

#include "core/probability.hpp"
#include "core/solve.hpp"

namespace qerr {

namespace {

constexpr Eigen::Index blocks = 32, patterns = 3, fewest_rows = 16;  // per block

std::size_t state_of(double edge) { return static_cast<std::size_t>(edge - 4 * std::floor(edge / 4)); }

/// Displacements of the four edges from their mean, by the readings [first, end). NaN: an edge has no
/// readings.
Eigen::Vector4d displacements(const Evidence& e, const Eigen::ArrayXd& position, Eigen::Index first,
                              Eigen::Index end) {
  Eigen::Vector4d wrong = Eigen::Vector4d::Zero(), all = Eigen::Vector4d::Zero();
  for (Eigen::Index i = first; i < end; ++i) {
    const double reading = std::round(e.measured[i] / e.step()), edge = std::round(position[i]);
    if (reading != edge && reading != edge - 1) continue;
    const std::size_t k = state_of(edge);
    const bool above = reading == edge, expected = position[i] >= edge;
    wrong[static_cast<Eigen::Index>(k)] += static_cast<double>(expected) - static_cast<double>(above);
    all[static_cast<Eigen::Index>(k)] += 1;
  }
  const Eigen::Vector4d d = wrong.cwiseQuotient(all);
  return d.array() - d.mean();
}

}  // namespace

double EdgePattern::largest() const {
  double most = 0;
  for (const double d : displacement) most = std::max(most, std::abs(d));
  return most;
}

EdgePattern edge_pattern(const Evidence& e, const Explanation& m) {
  EdgePattern p;
  const Eigen::Index n = e.rows();
  if (!e.counted || n < blocks * fewest_rows) return p;
  // In counts, with the edges at whole numbers: edge k at the position k.
  const Eigen::ArrayXd position = (e.path + m.addition()) / e.step() + below_reading(e.encoder);
  Eigen::MatrixXd contrasts(blocks, patterns);
  Eigen::Matrix<double, patterns, 4> basis;
  basis << -0.5, 0.5, -0.5, 0.5, 1, 0, -1, 0, 0, 1, 0, -1;
  for (Eigen::Index b = 0; b < blocks; ++b)
    contrasts.row(b) = basis * displacements(e, position, b * n / blocks, (b + 1) * n / blocks);
  if (!contrasts.allFinite()) return p;
  const Eigen::RowVectorXd mean = contrasts.colwise().mean();
  const Eigen::MatrixXd about = contrasts.rowwise() - mean;
  constexpr double b = blocks, d = patterns;
  Eigen::MatrixXd covariance = about.transpose() * about / (b * (b - 1));
  covariance.diagonal().array() += 1e-12;
  const double t_squared = mean * solve_symmetric(covariance, mean.transpose());
  p.p_value = fisher_f_tail(t_squared * (b - d) / (d * (b - 1)), d, b - d);
  const Eigen::Vector4d all = displacements(e, position, 0, n);
  for (std::size_t k = 0; k < 4; ++k) p.displacement[k] = all[static_cast<Eigen::Index>(k)];
  p.alternating = basis.row(0) * all;
  p.alternating_error = std::sqrt(covariance(0, 0));
  return p;
}

Intervals displaced(Intervals intervals, const Evidence& e, const EdgePattern& p) {
  for (Eigen::Index i = 0; i < e.rows(); ++i) {
    const double reading = std::round(e.measured[i] / e.step());
    intervals.lower[i] += p.displacement[state_of(reading)] * e.step();
    intervals.upper[i] += p.displacement[state_of(reading + 1)] * e.step();
  }
  return intervals;
}

}  // namespace qerr
