/// Distribution functions, compiled once (Boost.Math with its default policy: relative error about 1e-14).
/// A tail is P(X > x); a quantile is the value x with P(X <= x) = p. Degrees of freedom are > 0 and need not
/// be integers.
/// @throws std::domain_error outside the domain of the distribution
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace qerr {

/// The upper of the two middle values where their number is even; 0 without values.
double median(std::vector<double>);

/// The rows in ascending order of a column's values.
std::vector<Eigen::Index> ascending_rows(const Eigen::ArrayXd&);

/// Place of a percentile among sorted values v: (1 - part) v[below] + part v[below + 1].
struct PercentileRank {
  std::uint64_t below = 0;
  double part = 0;

  /// @param fraction  0.95 of the 95th percentile
  /// @pre count > 0
  PercentileRank(double fraction, std::uint64_t count);

  /// More values than this beyond a limit exceed it for certain.
  std::uint64_t permitted(std::uint64_t count) const { return count - 1 - below; }
};

/// Of no values each of these is 0.
double rms(const Eigen::ArrayXd&);
double standard_deviation(const Eigen::ArrayXd&);  ///< about the mean, divided by the number of values
double peak_to_peak(const Eigen::ArrayXd&);
/// Pearson's coefficient; 0 if one of them is constant.
double correlation(const Eigen::ArrayXd&, const Eigen::ArrayXd&);

/// Correlation of neighbouring values of zero mean; 0 where all are zero.
double lag_one_correlation(const Eigen::ArrayXd&);

/// y = intercept + slope x.
struct Line {
  double intercept = 0, slope = 0;
  double residual_rms = 0;  ///< of y - intercept - slope x
};

/// By least squares; the slope is 0 where all x are the same.
Line fit_line(const Eigen::ArrayXd& x, const Eigen::ArrayXd& y);

/// P(X <= z) of the standard normal distribution.
double normal_cdf(double z);

/// P(a < X <= b) of the standard normal distribution, a <= b, without cancellation in either tail.
double normal_probability(double a, double b);

double normal_quantile(double probability);

double student_t_tail(double t, double degrees);
double student_t_quantile(double probability, double degrees);

double chi_squared_tail(double x, double degrees);

/// The x at which the tail is `probability`.
double chi_squared_tail_quantile(double probability, double degrees);

/// Noncentrality at which P(X > threshold) = power for a noncentral chi-squared X.
double noncentrality_for_power(double threshold, double degrees, double power);

/// Tail of the F distribution.
double fisher_f_tail(double f, double numerator_degrees, double denominator_degrees);

}  // namespace qerr
