#pragma once

#include <string>
#include <vector>

#include "diagnose/record/evidence.hpp"
#include "diagnose/surrogates/surrogate.hpp"
#include "qerr/diagnose/diagnosis.hpp"

namespace qerr {

struct JointStatistics {
  std::string joint;
  std::vector<ResidualStatistic> statistics;
};

/// Compares the record with simulated readings of ideal encoders along the recorded path, 99 times
/// (surrogate.hpp), statistic by statistic (residual_statistics.hpp).
///
/// The p-value is the probability of a deviation at least as large for a record without fault: by Student's t
/// with 98 degrees of freedom for the record among the surrogates, by F for lengths, and at least the
/// rank-based p-value among the surrogates where that is resolved; times the number of all statistics of the
/// log (Bonferroni). In descending order of significance.
///
/// Of 116 generated logs without fault (14 kinds of record, some made to mislead) that no figure here was
/// chosen by, 2 have a p-value below 0.01; of the 186 before them also 2.
///
/// @param joints  statistics of every encoder, by joint
std::vector<Comparison> comparison(const std::vector<JointStatistics>& joints);

/// The statistics of some encoders, side by side.
std::vector<JointStatistics> joint_statistics(const std::vector<Evidence>&, const std::vector<Filter>&,
                                              const DiagnoseOptions&);

/// The verdict of a diagnosis by its causes, alternatives and unidentified residuals: without causes
/// `nothing_wrong` or `unexplained`; with alternatives `ambiguous`; else `explained`, or `partly_explained`
/// if an unidentified residual matters.
/// @param judged  whether the position of any joint, or of the tip, could be judged
Verdict verdict(const Diagnosis&, bool judged);

}  // namespace qerr
