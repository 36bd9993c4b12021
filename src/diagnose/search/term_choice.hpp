#pragma once

#include <string>
#include <vector>

#include "diagnose/search/error_model.hpp"

namespace qerr {

/// What earlier passes of a search have taught about the choice of terms.
struct ChoiceHistory {
  std::vector<std::string> found;         ///< families of the previous pass's richest set
  std::vector<std::string> refuted;       ///< families that no set may have
  bool names = true;                      ///< whether a set may have effects of the catalogue
  bool arcs = false;                      ///< whether it may have a short part of one period per revolution
  double worth = 0, worth_of_shapes = 0;  ///< ErrorModel::price
};

/// The set of least criterion. Searches twice: the first time as if samples shared no more than their path's
/// noise, for the residual of the richest model, whose autocorrelation gives the number of independent
/// samples.
Choice choose_terms(ErrorModel&, const ChoiceHistory&);

/// Refines the shapes of chosen terms (rates, time constants, sizes of hystereses, linearizations) by a
/// Gauss-Newton step of all at once, and forgets what scans have found but no set has chosen.
/// @returns whether any shape changed by more than it matters
bool refine_shapes(const ErrorModel&, const Choice&, Scanned&);

}  // namespace qerr
