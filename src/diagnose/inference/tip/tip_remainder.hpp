#pragma once

#include <vector>

#include "diagnose/inference/tip/tip_model.hpp"
#include "qerr/diagnose/diagnosis.hpp"

namespace qerr {

/// What is left of a tip that is computed, as in a simulated log, and not tracked: rounding errors, without a
/// meaning [m].
inline constexpr double computed_tip = 1e-9;

/// What a fit at the tip leaves that is neither quantization nor white noise: a step, a line of a frequency,
/// or a slow change, in the order of the rows; poses without stamps are in the order in which they were
/// taken.
///
/// The periodograms of the remainder's coordinates are compared with those of `TipModel::surrogates` plus
/// white noise of the fitted sigma, in windows of 4 and of 40 independent frequencies, and its largest shift
/// of the mean with theirs. A window or a shift is reported if it exceeds that of every surrogate by half,
/// and is 5 % of the variance at least; a shift, where no window is left without it.
/// @param left  of the fit, rows x logged coordinates [m]
/// @returns at most one; none of fewer than 24 rows
std::vector<Unidentified> tip_remainder(const TipModel&, const Eigen::MatrixXd& left);

/// What a tracker, its target or a link may do during the record: wander along each coordinate, as a
/// polynomial of time of degree 1, 2, 4 or 8, or exponentially towards an end; one displacement from the row
/// on where what the model leaves has its largest shift; grow exponentially along the link towards an end.
/// None of fewer than 24 rows.
std::vector<TipTerm> tracker_terms(const TipModel&);

/// Moves displacements that were chosen before other causes were to the rows where these leave them.
void settle_knocks(TipModel&);

/// Such a term as a finding: nothing that a model of the machine reproduces.
Unidentified tracker_finding(const TipModel&, std::size_t term);

}  // namespace qerr
