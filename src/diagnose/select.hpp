#pragma once

#include <vector>

#include "explanation.hpp"

namespace qerr {

struct SelectOptions {
  double alpha = 0.01;            ///< of a false name in one encoder's record, over all candidates
  double least_amplitude = 0.05;  ///< rms of what a cause adds [counts]: less is not worth a name
  std::size_t most_terms = 6;
};

/// What could stand in a chosen term's place almost as well.
struct Alternative {
  std::size_t term;
  Effect effect;
  double loss = 0;  ///< of log-likelihood against the chosen one
};

struct Selection {
  Explanation model;
  std::vector<double> p_values;  ///< of each term against the model without it
  std::vector<Alternative> alternatives;
};

/// Names what an encoder's record asks for: forward by likelihood among the terms that pass their test,
/// then what stopped to matter is dropped and each term is tried against every other one.
Selection select(const Evidence&, const SelectOptions& = {});

}  // namespace qerr
