#pragma once

#include <Eigen/Core>
#include <vector>

#include "diagnose/inference/interval_likelihood.hpp"
#include "diagnose/record/evidence.hpp"
#include "effect/term.hpp"

namespace qerr {

/// Model of one encoder's readings: the path, a sum of terms and Gaussian noise, quantized.
///
/// reading = quantized(path + sum of terms + noise). Coefficients and noise maximize the likelihood of the
/// readings (interval_likelihood.hpp), in which quantization is exact at any speed.
class Explanation {
 public:
  explicit Explanation(const Evidence&, std::vector<Term> = {});

  void add(Term);
  void remove(std::size_t term);
  void fit();

  /// Variance of the score of columns, estimated from sums over blocks, over its variance for residuals that
  /// are independent from row to row.
  double variance_inflation(const Eigen::ArrayXXd& columns) const;

  const std::vector<Term>& terms() const { return terms_; }
  Eigen::VectorXd coefficients(std::size_t term) const;
  const Eigen::ArrayXd& addition() const { return x_; }  ///< sum of all terms
  double log_likelihood() const { return likelihood_.log_likelihood; }
  double noise() const { return sigma_; }
  /// Standard deviation about the path, row by row: the noise, widened by the spec's random effects.
  Eigen::ArrayXd scatter() const { return sigma_ * relative_; }
  /// Expected fraction of outliers.
  double outliers() const { return likelihood_.outliers / static_cast<double>(evidence_->rows()); }
  const IntervalLikelihood& likelihood() const { return likelihood_; }
  const Intervals& intervals() const { return intervals_; }
  double mean_offset() const;  ///< of the constant term

 private:
  Eigen::Index first_coefficient(std::size_t term) const;
  IntervalLikelihood at(const Eigen::VectorXd& unit, double sigma, double outliers) const;
  double least_noise() const;
  Eigen::VectorXd assemble_columns();
  void fit_plainly();
  Eigen::ArrayXd moved_before(std::size_t term) const;
  bool follow_path();
  void fit_along_path();
  void fit_nonlinear();
  void initialize(Eigen::VectorXd& unit);
  void maximize(Eigen::VectorXd& unit, double outliers);

  const Evidence* evidence_;
  Intervals intervals_;
  Eigen::ArrayXXd base_;  ///< nuisance terms: the free zero of an encoder
  std::vector<Term> terms_;
  Eigen::VectorXd beta_;
  Eigen::MatrixXd columns_;  ///< of all terms, scaled to unit norm
  Eigen::ArrayXd fixed_;     ///< sum of the terms' `fixed` parts
  Eigen::ArrayXd relative_;  ///< random sigma of each row over the residual noise of the reference
  Eigen::ArrayXd x_;
  double spread_ = 0;
  double sigma_ = 0;
  IntervalLikelihood likelihood_;  ///< with outliers
};

}  // namespace qerr
