#pragma once

#include "explanation.hpp"

namespace qerr {

/// Rows that say together what one independent reading would: how much more a sum over what a model leaves
/// (the scores of its likelihood) scatters than it would if the rows were independent,
///   1 + 2 sum_k r_k,
/// r_k their autocorrelation at k rows, up to where two neighbouring lags no longer make a positive sum
/// (Geyer 1992). At least 1. A table that was interpolated between fewer points, a reference that was
/// filtered, and a shape that no term has leave rows that repeat each other; likelihoods and numbers of rows
/// divided by this count each of them once.
/// @param model  with all that can be explained: what it lacks would count as repetition
double rows_alike(const Explanation& model);

}  // namespace qerr
