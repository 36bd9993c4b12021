#pragma once

#include <Eigen/Core>
#include <vector>

namespace qerr {

/// The upper of the two middle values where their number is even; 0 without values.
double median(std::vector<double>);

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

}  // namespace qerr
