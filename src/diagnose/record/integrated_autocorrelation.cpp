#include "diagnose/record/integrated_autocorrelation.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

#include "core/solve.hpp"
#include "diagnose/terms/unnamed_terms.hpp"

namespace qerr {

namespace {

/// Residual over the reference's noise up to which rows count as independent (convention).
constexpr double reference_noise_only = 1.3;

/// Smaller values are within the error of the estimate for short records (convention).
constexpr double noticeable = 2.5;

constexpr Eigen::Index knots = 24;  ///< of the tables of position and time

/// Longest lag: this part of the record. Longer ones are estimated from too few independent products.
constexpr Eigen::Index lags_per_record = 16;

/// Sum of the products of scores that are `lag` rows apart.
double lagged_products(const Eigen::ArrayXd& scores, Eigen::Index lag) {
  const Eigen::Index n = scores.size() - lag;
  return (scores.head(n) * scores.tail(n)).sum();
}

/// 1 + 2 sum of the autocorrelation.
double integrated(const Eigen::ArrayXd& scores) {
  const double power = scores.square().sum();
  if (!(power > 0)) return 1;
  double sum = 1;
  const Eigen::Index longest = scores.size() / lags_per_record;
  for (Eigen::Index lag = 1; lag + 1 <= longest; lag += 2) {
    const double pair = (lagged_products(scores, lag) + lagged_products(scores, lag + 1)) / power;
    if (pair <= 0) break;
    sum += 2 * pair;
  }
  return std::clamp(sum, 1.0, std::max(1.0, static_cast<double>(longest)));
}

/// The larger one of the order of time and that of the position.
double integrated(const Evidence& e, const Eigen::ArrayXd& scores) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(e.rows()));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](Eigen::Index a, Eigen::Index b) { return e.path[a] < e.path[b]; });
  return std::max(integrated(scores), integrated(scores(order)));
}

/// Scores less their least-squares fit by coarse tables of position and time.
Eigen::ArrayXd without_tables(const Evidence& e, const Eigen::ArrayXd& scores) {
  Eigen::MatrixXd tables = position_table_term(e, knots).columns;
  if (e.ordered) {
    tables.conservativeResize(Eigen::NoChange, 2 * (knots - 1));
    tables.rightCols(knots - 1) = time_table_term(e, knots).columns;
  }
  Eigen::MatrixXd normal = tables.transpose() * tables;
  // At constant speed position and time are collinear.
  normal.diagonal().array() += 1e-8 * normal.diagonal().mean();
  return scores - (tables * solve_symmetric(normal, tables.transpose() * scores.matrix())).array();
}

}  // namespace

double integrated_autocorrelation(const Evidence& e, const Explanation& model) {
  const double reference_noise = std::max({e.noise, 0.3 * e.log_resolution, 1e-3 * e.step()});
  if (model.plain_noise() < reference_noise_only * reference_noise || e.rows() < 8 * knots) return 1;
  const Eigen::ArrayXd scores = model.plain().score - model.plain().score.mean();
  const double rows = integrated(e, without_tables(e, scores));
  return rows < noticeable ? 1 : rows;
}

}  // namespace qerr
