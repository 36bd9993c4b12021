#include "diagnose/inference/tip/tip_solution.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/solve.hpp"
#include "diagnose/search/linear_model.hpp"

namespace qerr {

namespace {

constexpr double rank_tolerance = 1e-12;  // of the scaled normal matrix

double log_likelihood(const Eigen::VectorXd& residual, const Eigen::VectorXd& known, double sigma) {
  const Eigen::ArrayXd variance = known.array() + sigma * sigma;
  // Logarithms of eight factors at a time, which lie between 1 and some 1e18.
  const Eigen::ArrayXd ratio = 1 + known.array() / (sigma * sigma);
  const Eigen::Index part = ratio.size() / 8;
  Eigen::ArrayXd product = ratio.head(part);
  for (Eigen::Index i = 1; i < 8; ++i) product *= ratio.segment(i * part, part);
  const double logarithms = product.log().sum() + ratio.tail(ratio.size() - 8 * part).log().sum();
  return -0.5 * (logarithms + (residual.array().square() / variance).sum()) -
         static_cast<double>(residual.size()) * (std::log(sigma) + 0.5 * std::log(2 * std::numbers::pi));
}

/// Uphill in sigma, by smaller and smaller factors. Each move raises the likelihood, so that no sigma comes
/// back, and by the range of doubles a factor has finitely many: the first, 4, some thousand; each further
/// one goes between two neighbours of its predecessor. Where not even the last factor goes uphill, as from
/// the sigma of a model that hardly differs, none does.
double climb(const Eigen::VectorXd& residual, const Eigen::VectorXd& known, double sigma, double least) {
  constexpr double last = 1.0055;
  double best = log_likelihood(residual, known, sigma);
  const auto is_uphill = [&](double to) { return to >= least && log_likelihood(residual, known, to) > best; };
  if (!is_uphill(sigma * last) && !is_uphill(sigma / last)) return sigma;
  for (double factor = 4; factor > 1.005; factor = std::sqrt(factor))
    for (const double by : {1 / factor, factor})
      while (sigma * by >= least) {
        const double next = log_likelihood(residual, known, sigma * by);
        if (!(next > best)) break;  // also for a likelihood beyond the range of doubles
        sigma *= by;
        best = next;
      }
  return sigma;
}

}  // namespace

NormalInverse::NormalInverse(const Eigen::MatrixXd& matrix) {
  if (matrix.cols() == 0) return;
  Eigen::VectorXd scale = matrix.diagonal().cwiseSqrt();
  for (double& s : scale) s = s > 0 ? 1 / s : 0;
  SymmetricEigen eigen = symmetric_eigen(scale.asDiagonal() * matrix * scale.asDiagonal());
  Eigen::VectorXd inverted = std::move(eigen.values);
  const double least = rank_tolerance * std::max(1.0, inverted.maxCoeff());
  rank = (inverted.array() > least).count();
  for (double& v : inverted) v = v > least ? 1 / v : 0;
  const Eigen::MatrixXd vectors = scale.asDiagonal() * eigen.vectors;
  inverse = vectors * inverted.asDiagonal() * vectors.transpose();
}

TipSolution solve(const Eigen::MatrixXd& x, const Eigen::VectorXd& y, const Eigen::VectorXd& known,
                  double least, std::optional<double> start) {
  TipSolution s;
  s.residual = y;
  s.theta = Eigen::VectorXd::Zero(x.cols());
  s.sigma = std::max(least, start ? *start : std::sqrt(y.squaredNorm() / static_cast<double>(y.size())));
  for (int i = 0; i < 12; ++i) {
    s.weight = (known.array() + s.sigma * s.sigma).inverse().matrix();
    if (x.cols() > 0) {
      const Eigen::MatrixXd gram = weighted_gram(x, y, s.weight);
      const NormalInverse normal(gram.topLeftCorner(x.cols(), x.cols()));
      s.theta = normal.inverse * gram.col(x.cols()).head(x.cols());
      s.covariance = normal.inverse;
      s.rank = normal.rank;
      s.residual = y - x * s.theta;
    }
    const double before = s.sigma;
    s.sigma = climb(s.residual, known, s.sigma, least);
    if (std::abs(s.sigma - before) < 0.01 * before) break;
  }
  s.log_likelihood = log_likelihood(s.residual, known, s.sigma);
  return s;
}

}  // namespace qerr
