#pragma once

#include "diagnose/inference/explanation.hpp"

namespace qerr {

/// Rows that say together what one independent reading would: how much more a sum over what a model leaves
/// (the scores of its likelihood) scatters than it would if the rows were independent,
///   1 + 2 sum_k r_k,
/// r_k their autocorrelation at k rows, up to where two neighbouring lags no longer make a positive sum
/// (Geyer 1992). It is 1 where that is not noticeably more, or where no more is left than the reference's
/// noise. A table that was interpolated between fewer points, a reference that was filtered, and a shape that
/// no term has leave rows that repeat each other; likelihoods and numbers of rows divided by this count each
/// of them once. Rows are taken in the order of time and in that of the position, where passes over the same
/// place lie side by side, and the larger figure counts.
/// @param model  with all that can be explained: what it lacks would count as repetition, but for what a
///   coarse table of the position and one of time take up
double integrated_autocorrelation(const Evidence&, const Explanation& model);

}  // namespace qerr
