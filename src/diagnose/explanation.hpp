#pragma once

#include <optional>
#include <vector>

#include "interval_likelihood.hpp"
#include "term.hpp"

namespace qerr {

/// How strongly the evidence asks for a term that a model does not have.
struct ScoreTest {
  double gain = 0;     ///< of the log-likelihood, by one Newton step
  double p_value = 1;  ///< of no such effect, with errors that are correlated within a block
};

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

  ScoreTest test(const Eigen::ArrayXXd& columns) const;

  const std::vector<Term>& terms() const { return terms_; }
  Eigen::VectorXd coefficients(std::size_t term) const;
  Eigen::ArrayXd addition() const { return x_ - evidence_->reference; }  ///< what all terms add
  double log_likelihood() const { return likelihood_.log_likelihood; }
  double noise() const { return sigma_; }
  const IntervalLikelihood& likelihood() const { return likelihood_; }

 private:
  Eigen::ArrayXXd all_columns() const;
  void place();
  void fit_noise();

  const Evidence* evidence_;
  Intervals intervals_;
  Eigen::ArrayXXd base_;  ///< terms that are nobody's fault: the constant of an encoder whose zero is free
  std::vector<Term> terms_;
  Eigen::VectorXd beta_;
  Eigen::ArrayXd x_;
  double sigma_ = 0;
  IntervalLikelihood likelihood_;
};

}  // namespace qerr
