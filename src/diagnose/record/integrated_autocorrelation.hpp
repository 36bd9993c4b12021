#pragma once

#include "diagnose/inference/explanation.hpp"

namespace qerr {

/// Integrated autocorrelation of the scores of a model's likelihood [rows]: the factor by which the variance
/// of a sum over the rows exceeds that of independent rows,
///   1 + 2 sum_k r_k,
/// r_k the autocorrelation at k rows. The sum ends where two neighbouring lags have a negative sum (initial
/// positive sequence; Geyer, Statistical Science 7, 1992). Rows are correlated in tables that were
/// interpolated between fewer points, with filtered references, and by errors that no term of the model
/// describes.
///
/// The larger value of two orders of the rows is returned: by time and by position, in which repeated passes
/// over one position are neighbours. It is 1 if it is not noticeably larger, or if the residual is the noise
/// of the reference.
/// @param model  with all identifiable terms, as missing ones would count as correlation; the part that
///   coarse tables of position and time explain is removed first
double integrated_autocorrelation(const Evidence&, const Explanation& model);

}  // namespace qerr
