#include "core/statistics.hpp"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/non_central_chi_squared.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <numbers>
#include <numeric>

namespace qerr {

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<Eigen::Index> ascending_rows(const Eigen::ArrayXd& x) {
  std::vector<Eigen::Index> rows(static_cast<std::size_t>(x.size()));
  std::iota(rows.begin(), rows.end(), Eigen::Index{0});
  std::ranges::stable_sort(rows, [&](Eigen::Index a, Eigen::Index b) { return x[a] < x[b]; });
  return rows;
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

double normal_cdf(double z) { return 0.5 * std::erfc(-z / std::numbers::sqrt2); }

double normal_probability(double a, double b) {
  // Both values come from the tail on the side of the interval, so that their difference keeps its digits.
  const double sign = a + b < 0 ? -1 : 1;
  return 0.5 *
         std::abs(std::erfc(sign * a / std::numbers::sqrt2) - std::erfc(sign * b / std::numbers::sqrt2));
}

double normal_quantile(double probability) { return quantile(boost::math::normal(), probability); }

double student_t_tail(double t, double degrees) {
  return cdf(complement(boost::math::students_t(degrees), t));
}

double student_t_quantile(double probability, double degrees) {
  return quantile(boost::math::students_t(degrees), probability);
}

double chi_squared_tail(double x, double degrees) {
  return cdf(complement(boost::math::chi_squared(degrees), x));
}

double chi_squared_tail_quantile(double probability, double degrees) {
  return quantile(complement(boost::math::chi_squared(degrees), probability));
}

double noncentrality_for_power(double threshold, double degrees, double power) {
  return boost::math::non_central_chi_squared::find_non_centrality(degrees, threshold, 1 - power);
}

double fisher_f_tail(double f, double numerator_degrees, double denominator_degrees) {
  return cdf(complement(boost::math::fisher_f(numerator_degrees, denominator_degrees), f));
}

}  // namespace qerr
