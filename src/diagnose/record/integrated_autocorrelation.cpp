#include "diagnose/record/integrated_autocorrelation.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

#include "core/solve.hpp"

namespace qerr {

namespace {

constexpr double more_than_noise = 1.3;  ///< of the reference: what that leaves is independent
constexpr double noticeable = 2.5;

constexpr Eigen::Index knots = 24;
constexpr Eigen::Index fewest_readings = 16;  ///< that a record keeps: longer lags are not estimated

/// Sum of products of scores that are `lag` rows apart.
double correlation(const Eigen::ArrayXd& scores, Eigen::Index lag) {
  const Eigen::Index n = scores.size() - lag;
  return (scores.head(n) * scores.tail(n)).sum();
}

/// 1 + 2 sum of the autocorrelation of what stands in an order.
double repetition(const Eigen::ArrayXd& scores) {
  const double power = scores.square().sum();
  if (!(power > 0)) return 1;
  double sum = 1;
  const Eigen::Index longest = scores.size() / fewest_readings;
  for (Eigen::Index lag = 1; lag + 1 <= longest; lag += 2) {
    const double pair = (correlation(scores, lag) + correlation(scores, lag + 1)) / power;
    if (pair <= 0) break;
    sum += 2 * pair;
  }
  return std::clamp(sum, 1.0, std::max(1.0, static_cast<double>(longest)));
}

/// The same in the order of time, and in that of the position, whichever is larger.
double repetition(const Evidence& e, const Eigen::ArrayXd& scores) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(e.rows()));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](Eigen::Index a, Eigen::Index b) { return e.path[a] < e.path[b]; });
  return std::max(repetition(scores), repetition(scores(order)));
}

/// Scores without what coarse tables of the position and of time make of them, by one least-squares step.
Eigen::ArrayXd without_tables(const Evidence& e, const Eigen::ArrayXd& scores) {
  Eigen::MatrixXd tables = position_table_term(e, knots).columns;
  if (e.ordered) {
    tables.conservativeResize(Eigen::NoChange, 2 * (knots - 1));
    tables.rightCols(knots - 1) = time_table_term(e, knots).columns;
  }
  Eigen::MatrixXd normal = tables.transpose() * tables;
  // At a constant speed position and time are one.
  normal.diagonal().array() += 1e-8 * normal.diagonal().mean();
  return scores - (tables * solve_symmetric(normal, tables.transpose() * scores.matrix())).array();
}

}  // namespace

double integrated_autocorrelation(const Evidence& e, const Explanation& model) {
  const double own = std::max({e.noise, 0.3 * e.log_resolution, 1e-3 * e.step()});
  if (model.plain_noise() < more_than_noise * own || e.rows() < 8 * knots) return 1;
  const Eigen::ArrayXd scores = model.plain().score - model.plain().score.mean();
  const double alike = repetition(e, without_tables(e, scores));
  return alike < noticeable ? 1 : alike;
}

}  // namespace qerr
