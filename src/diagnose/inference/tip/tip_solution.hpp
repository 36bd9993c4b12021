#pragma once

#include <Eigen/Core>
#include <optional>

namespace qerr {

/// Pseudo-inverse of a normal matrix X^T W X, scaled to be independent of units; directions with singular
/// values of X below 1e-6 of the largest are omitted.
struct NormalInverse {
  Eigen::MatrixXd inverse;
  Eigen::Index rank = 0;

  explicit NormalInverse(const Eigen::MatrixXd& normal);
};

/// Coefficients that maximize the likelihood of entries y = X theta + Gaussian of the variances
/// known + sigma^2.
struct TipSolution {
  Eigen::VectorXd theta;
  Eigen::MatrixXd covariance;  ///< of theta; 0 in unobservable directions
  Eigen::VectorXd residual;    ///< y - X theta [m]
  Eigen::VectorXd weight;      ///< 1/(known + sigma^2) [1/m^2]
  double sigma = 0;            ///< beside the quantization [m]
  double log_likelihood = 0;
  Eigen::Index rank = 0;  ///< of X
};

/// @param known  variances of the entries beside sigma^2 [m^2]
/// @param least  of sigma, above 0 [m]
/// @param start  of the search for sigma, such as that of a similar X [m]; without it the rms of y
TipSolution solve(const Eigen::MatrixXd& x, const Eigen::VectorXd& y, const Eigen::VectorXd& known,
                  double least, std::optional<double> start = {});

}  // namespace qerr
