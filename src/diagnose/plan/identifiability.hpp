#pragma once

#include <vector>

#include "diagnose/plan/planned_record.hpp"
#include "effect/term.hpp"
#include "qerr/diagnose/plan.hpp"

namespace qerr {

// Criteria of a plan, in log-likelihood unless stated (conventions).

inline constexpr double worth_trying = 8;            ///< least gain of a term
inline constexpr double worth_a_term = 3;            ///< least improvement of Schwarz's criterion by a term
inline constexpr double worth_comparing = 0.5;       ///< squared correlation from which terms are compared
inline constexpr double indistinguishable_loss = 6;  ///< largest loss of an alternative
inline constexpr double similar_part = 0.96;         ///< part of the variance that an alternative reproduces
inline constexpr int scanned_hypotheses = 2000;      ///< times and orders that a scan compares

/// Fisher information of one quantized reading x + noise, averaged over the position in a count.
///
/// With P_k(x) the probability of the count k, z the distances of its edges in units of the noise and phi the
/// normal density,
///   I_x = 1/s^2 integral_0^1 sum_k (phi(z_k) - phi(z_k+1))^2 / P_k dx,
///   I_log s = integral_0^1 sum_k (z_k phi(z_k) - z_k+1 phi(z_k+1))^2 / P_k dx.
struct ReadingInformation {
  double position = 0;   ///< of the position [1/count^2]
  double log_sigma = 0;  ///< of the logarithm of the noise's standard deviation
};

/// @param noise  of the reference, standard deviation s [counts], > 0
ReadingInformation reading_information(double noise);

/// From which size on one encoder's record shows each term of the catalogue, and distinguishes it from
/// others.
///
/// All figures follow from one normal matrix, X^T W X of the columns of all terms [counts], with the number
/// of readings per row as weights: the information on the coefficients, the information that remains if other
/// columns are fitted too (Schur complement), and the variance of the contributions.
///
/// The record must outlive this object.
class Identifiability {
 public:
  Identifiability(const PlannedRecord&, const PlanOptions&);
  Identifiability(const Identifiability&) = delete;
  Identifiability& operator=(const Identifiability&) = delete;

  /// One for every term of the catalogue, and one for a lost count in the middle of the record.
  std::vector<PlannedEffect> effects() const;

  const ReadingInformation& information() const { return information_; }
  double readings() const { return readings_; }

 private:
  /// Coefficients with one common size: a sine and its cosine, or a single column.
  struct Coefficients {
    std::size_t term = 0;
    Eigen::Index first = 0, size = 1;  ///< columns of the normal matrix
  };
  std::vector<Coefficients> parameters_of(std::size_t term) const;
  PlannedEffect planned_effect(const Coefficients&) const;
  CorrelatedEffect correlated_effect(const Coefficients&, std::size_t other) const;
  Eigen::MatrixXd remaining_normal(const Coefficients&, std::size_t other) const;
  double selection_threshold(const Term&) const;
  double reportable_size(const Coefficients&, bool about_mean) const;

  const PlannedRecord& record_;
  PlanOptions options_;
  ReadingInformation information_;
  double readings_;
  std::vector<Term> terms_;
  std::vector<Eigen::Index> first_;  ///< column of each term
  Eigen::VectorXd peak_;             ///< largest entry of each column [counts]
  Eigen::MatrixXd normal_;           ///< the first column is the constant
};

}  // namespace qerr
