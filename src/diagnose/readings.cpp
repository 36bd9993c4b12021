#include "readings.hpp"

#include <algorithm>

namespace qerr {

namespace {

constexpr Eigen::Index fewest_readings = 16;  ///< that a record keeps: longer lags are not estimated

/// Sum of products of scores that are `lag` rows apart.
double correlation(const Eigen::ArrayXd& scores, Eigen::Index lag) {
  const Eigen::Index n = scores.size() - lag;
  return (scores.head(n) * scores.tail(n)).sum();
}

}  // namespace

double rows_alike(const Explanation& model) {
  const Eigen::ArrayXd scores = model.likelihood().score - model.likelihood().score.mean();
  const double power = scores.square().sum();
  if (!(power > 0)) return 1;
  double sum = 1;
  const Eigen::Index longest = scores.size() / fewest_readings;
  for (Eigen::Index lag = 1; lag + 1 <= longest; lag += 2) {
    const double pair = (correlation(scores, lag) + correlation(scores, lag + 1)) / power;
    if (pair <= 0) break;
    sum += 2 * pair;
  }
  return std::clamp(sum, 1.0, static_cast<double>(longest));
}

}  // namespace qerr
