#include "core/statistics.hpp"

#include <algorithm>
#include <cmath>

namespace qerr {

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

PercentileRank::PercentileRank(double fraction, std::uint64_t count) {
  const double position = fraction * static_cast<double>(count - 1);
  below = static_cast<std::uint64_t>(position);
  part = position - static_cast<double>(below);
}

double rms(const Eigen::ArrayXd& x) { return x.size() > 0 ? std::sqrt(x.square().mean()) : 0; }

double standard_deviation(const Eigen::ArrayXd& x) { return x.size() > 0 ? rms(x - x.mean()) : 0; }

double peak_to_peak(const Eigen::ArrayXd& x) { return x.size() > 0 ? x.maxCoeff() - x.minCoeff() : 0; }

double correlation(const Eigen::ArrayXd& x, const Eigen::ArrayXd& y) {
  const double deviation = standard_deviation(x) * standard_deviation(y);
  return deviation > 0 ? ((x - x.mean()) * (y - y.mean())).mean() / deviation : 0;
}

double lag_one_correlation(const Eigen::ArrayXd& x) {
  const Eigen::Index n = x.size() - 1;
  const double power = x.square().sum();
  return n > 0 && power > 0 ? (x.head(n) * x.tail(n)).sum() / power : 0;
}

Line fit_line(const Eigen::ArrayXd& x, const Eigen::ArrayXd& y) {
  const double mean_x = x.mean(), mean_y = y.mean(), squares = (x - mean_x).square().sum();
  const double slope = squares > 0 ? ((x - mean_x) * (y - mean_y)).sum() / squares : 0;
  return {mean_y - slope * mean_x, slope, rms(y - mean_y - slope * (x - mean_x))};
}

}  // namespace qerr
