#pragma once

#include <vector>

#include "diagnose/plan/detection.hpp"
#include "diagnose/plan/planned_record.hpp"
#include "diagnose/terms/term.hpp"
#include "qerr/diagnose/plan.hpp"

namespace qerr {

/// How well one encoder's record shows the terms of the catalogue, and shows them apart.
///
/// All figures come from one normal matrix, X^T W X of all columns [counts] with the readings a row stands
/// for as weights: the information of the columns, what others can make of them (a Schur complement), and
/// their variance.
class Sight {
 public:
  Sight(const PlannedRecord&, const PlanOptions&);

  /// One for every named term, and one for a lost count in the middle of the record.
  std::vector<PlannedEffect> effects() const;

  const ReadingInformation& information() const { return information_; }
  double readings() const { return readings_; }

 private:
  /// Coefficients whose size is one number: a sine and its cosine, or a single column.
  struct Face {
    std::size_t term = 0;
    Eigen::Index first = 0, size = 1;  ///< columns of the normal matrix
  };
  std::vector<Face> faces(std::size_t term) const;
  PlannedEffect seen_by(const Face&) const;
  Rival rival_of(const Face&, std::size_t other) const;
  Eigen::MatrixXd beyond(const Face&, std::size_t other) const;
  double threshold(const Term&) const;
  double floor_of(const Face&, bool own_name) const;

  const PlannedRecord& record_;
  PlanOptions options_;
  ReadingInformation information_;
  double readings_;
  std::vector<Term> terms_;
  std::vector<Eigen::Index> first_;  ///< column of each term
  Eigen::VectorXd peak_;             ///< of each column [counts]
  Eigen::MatrixXd normal_;           ///< the constant comes first
};

}  // namespace qerr
