#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "diagnose/record/sampling.hpp"
#include "diagnose/search/dictionary.hpp"
#include "diagnose/search/linear_model.hpp"

namespace qerr {

/// Smallest error worth a term [counts, rms]: it raises the rms of the quantization error, 1/sqrt(12), by 6
/// %.
inline constexpr double material = 0.1;

/// Of a shorter part of a sine a cubic leaves less than 2.5 % (rms, worst phase): its order is doubtful
/// beside other curves [periods].
inline constexpr double distinct_periods = 0.5;

/// Variance of error samples beyond quantization and stated noise: constant, and in proportion to the square
/// of the speed (jitter of the stamps).
struct ExcessVariance {
  double constant = 0;   ///< [rad^2 or m^2]
  double per_speed = 0;  ///< [s^2]

  Eigen::ArrayXd at(const Evidence& e) const { return constant + per_speed * e.velocity.square(); }
};

/// A set of an error model's candidates and the regression on them.
struct Choice {
  LinearModel::Set chosen;
  LinearModel::Set richest;  ///< found as if samples shared no more than the path's noise
  LinearModel::Set named;    ///< the best of named terms alone
  LinearModel::Fit fit;      ///< of the chosen ones
  Eigen::ArrayXd residual;   ///< that they leave
  double correlation = 1;    ///< integrated autocorrelation of what the richest set leaves
  bool structured = false;   ///< it is more than that of the path's noise
};

/// Weighted regression of an encoder's error samples on the candidates of a dictionary.
class ErrorModel {
 public:
  /// @param events  times at which samples may be divided by a step
  /// @param clocks  that the previous pass has found: samples that they read beyond the record have no weight
  ErrorModel(const Evidence& record, const ErrorSamples&, std::vector<Candidate>,
             const std::vector<Event>& events, const std::vector<Effect>& clocks, const ExcessVariance&);

  const Evidence& record() const { return *record_; }
  const ErrorSamples& samples() const { return *samples_; }
  /// The record at the samples.
  const Evidence& sampled() const { return samples_->sampling.evidence; }

  const std::vector<Candidate>& candidates() const { return candidates_; }
  const Candidate& candidate(std::size_t i) const { return candidates_[i]; }
  const Term& term(std::size_t i) const { return *candidates_[i].term; }
  /// Periods that the samples cover of a term with a name and an order; infinity for any other.
  double periods(std::size_t i) const;
  /// Whether it is an order above the first that a cubic would fit nearly as well.
  bool is_arc(std::size_t i) const;
  const ColumnGroup& group(std::size_t i) const { return groups_[i]; }
  const std::vector<ColumnGroup>& groups() const { return groups_; }
  const LinearModel& linear() const { return *linear_; }
  Eigen::Index base() const { return base_; }
  const Eigen::ArrayXd& weight() const { return weight_; }
  double rows() const { return linear_->rows(); }
  /// Integrated autocorrelation of the samples' known variance: of the path's noise, which smoothing shares
  /// among neighbours.
  double correlation() const;

  /// Least variance of a residual, in units of the weights.
  double floor() const { return floor_; }
  /// Weights of samples of the same motion: what is too small to be worth a term is variance.
  Eigen::ArrayXd weights(const ErrorSamples&) const;

  /// Schwarz's price of the coefficients, that of the number of alternatives, and what makes a term material:
  /// a decrease of the mean square by the square of what is worth a term.
  /// @param worth            smallest size worth a term [rad or m, rms]; beside a table it is larger
  /// @param worth_of_shapes  the same of a shape that is not the catalogue's, and of a table
  void price(double independent, double worth, double worth_of_shapes);

  template <typename Which>
  void allow(Which which) {
    for (std::size_t i = 0; i < groups_.size(); ++i) groups_[i].allowed = which(i);
  }

  LinearModel::Fit fit(const LinearModel::Set& set) const { return linear_->fit(groups_, set); }
  bool possible(const LinearModel::Set& set, const LinearModel::Fit& f) const {
    return linear_->possible(groups_, set, f);
  }
  LinearModel::Set search(const LinearModel::Set& start, std::size_t locked, double independent) const {
    std::vector<LinearModel::Set> seen;
    return linear_->search(groups_, start, locked, independent, floor_, seen);
  }
  /// The best of the sets that searches from some starts lead to.
  LinearModel::Set search(const std::vector<LinearModel::Set>& starts, double independent) const;
  double criterion(const LinearModel::Set&, double independent) const;

  /// Base columns, then those of a set's groups in their order.
  Eigen::MatrixXd columns(const LinearModel::Set&) const;
  Eigen::ArrayXd residual(const LinearModel::Set&, const LinearModel::Fit&) const;
  /// Coefficients of the member at a position of a set.
  Eigen::VectorXd coefficients(const LinearModel::Set&, const LinearModel::Fit&, std::size_t position) const;
  /// Decrease of the weighted sum of squares of a residual by a term beside a constant.
  double gain(const Term&, const Eigen::ArrayXd& residual) const;
  /// Rise of the weighted sum of squares without the member at a position of a choice.
  double lost_without(const Choice&, std::size_t position) const;

  /// Tables and polynomials.
  bool is_table(std::size_t candidate) const {
    return candidates_[candidate].family == "time" || candidates_[candidate].family == "position";
  }
  /// Uncatalogued ramps and exponential approaches that begin at one time.
  bool is_transition(std::size_t candidate) const {
    return !term(candidate).named() && !term(candidate).step &&
           candidates_[candidate].family.starts_with("event");
  }
  /// Whether a set leaves no more than 1.3 times what rounding and noise leave in the readings: nothing worth
  /// mentioning.
  bool is_complete(const LinearModel::Set&) const;
  /// Mean over the samples that have a weight.
  double mean_of_used(const Eigen::ArrayXd& x) const;
  /// Residual variance per independent sample of a choice, in units of the weights.
  double scale(const Choice&) const;

 private:
  void list_groups();
  void weigh(const std::vector<Event>&, const std::vector<Effect>& clocks);

  const Evidence* record_;
  const ErrorSamples* samples_;
  ExcessVariance excess_;
  double floor_ = 0;
  std::vector<Candidate> candidates_;
  std::vector<ColumnGroup> groups_;
  Eigen::Index base_;
  Eigen::ArrayXd weight_;
  std::optional<LinearModel> linear_;
};

}  // namespace qerr
