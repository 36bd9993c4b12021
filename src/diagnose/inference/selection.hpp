#pragma once

#include <cstddef>
#include <vector>

#include "diagnose/inference/explanation.hpp"
#include "diagnose/search/cause_search.hpp"

namespace qerr {

/// A term that could replace a chosen one.
struct Alternative {
  std::size_t term;
  Effect effect;
};

/// The terms that explain an encoder's error, with the likelihood of the readings fitted to them.
struct Selection {
  Explanation model;
  std::vector<double> p_values;  ///< of each term against the model without it
  std::vector<double> lost;      ///< mean square that is not explained without each term [rad^2 or m^2]
  std::vector<Alternative> alternatives;
};

/// Standard deviation of a term's addition over the rows; of an offset, its magnitude [rad or m].
double size_of(const Explanation&, std::size_t term);

/// Mean square residual of a model [rad^2 or m^2].
double mean_square_residual(const Explanation&, const Evidence&);

/// The search's result with the likelihood of the readings in `sampling`.
Selection selection_of(const Sampling&, const FoundCauses&);

}  // namespace qerr
