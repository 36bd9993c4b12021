#pragma once

#include <optional>
#include <vector>

#include "interval_likelihood.hpp"
#include "term.hpp"

namespace qerr {

/// A model of one encoder's readings: terms whose sum lies between the edges of the readings but for a
/// Gaussian.
///
/// reading = quantized(path + sum of terms + noise). Coefficients and noise maximize the likelihood of the
/// readings (interval_likelihood.hpp), in which quantization is exact at any speed.
class Explanation {
 public:
  explicit Explanation(const Evidence&);

  void add(Term);
  void remove(std::size_t term);
  void fit();

  /// What further columns would gain in log-likelihood, by one Newton step.
  double gain(const Eigen::ArrayXXd& columns) const;

  /// How much more the score of columns scatters than it would if what is left were independent from reading
  /// to reading.
  double inflation(const Eigen::ArrayXXd& columns) const;

  const std::vector<Term>& terms() const { return terms_; }
  Eigen::VectorXd coefficients(std::size_t term) const;
  Eigen::ArrayXd addition() const { return x_ - evidence_->reference; }  ///< what all terms add
  double log_likelihood() const { return likelihood_.log_likelihood; }
  double noise() const { return sigma_; }
  double plain_noise() const { return plain_sigma_; }  ///< with nothing taken to be an outlier
  /// Part of the readings that the model takes to be outliers.
  double outliers() const { return likelihood_.outliers / static_cast<double>(evidence_->rows()); }
  const IntervalLikelihood& likelihood() const { return likelihood_; }
  const Intervals& intervals() const { return intervals_; }
  const Eigen::ArrayXd& position() const { return x_; }
  const IntervalLikelihood& plain() const { return plain_; }

 private:
  Eigen::ArrayXXd all_columns() const;
  IntervalLikelihood at(double sigma, double outliers) const;
  double least_noise() const;
  void climb_noise(double outliers);
  void maximize(const Eigen::MatrixXd& unit, Eigen::VectorXd& coefficients, double outliers);

  const Evidence* evidence_;
  Intervals intervals_;
  Eigen::ArrayXXd base_;  ///< terms that are nobody's fault: the constant of an encoder whose zero is free
  std::vector<Term> terms_;
  Eigen::VectorXd beta_;
  Eigen::ArrayXd x_;
  double spread_ = 0;
  double sigma_ = 0, plain_sigma_ = 0;
  IntervalLikelihood likelihood_;  ///< some readings being outliers
  IntervalLikelihood plain_;       ///< none being: what looks like outliers may be what is to be found
};

}  // namespace qerr
