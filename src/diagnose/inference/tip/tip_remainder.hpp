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

/// What a tracker that wanders adds to the tip, a slow function of time along each coordinate, where it alone
/// explains more than all causes that were found, by Schwarz's criterion.
/// @param alone  the model without causes
std::vector<Unidentified> wandering_tracker(const TipModel& alone, const TipModel& causes);

/// One displacement of the tracker, or of the target in the axes of the tip, from one row on, where it alone
/// leaves less than all causes that were found.
/// @param alone           the model without causes
/// @param left_by_causes  rms per coordinate [m]
std::vector<Unidentified> displaced_target(const TipModel& alone, double left_by_causes);

}  // namespace qerr
