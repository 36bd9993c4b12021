#pragma once

#include <vector>

#include "diagnose/inference/explanation.hpp"

namespace qerr {

struct SelectOptions {
  double alpha = 0.01;  ///< of a false name in one encoder's record, over all candidates
  /// Of records that names are known to explain nearly whole: the rest of it, too, is looked for among names.
  bool names_first = false;

  std::size_t most_terms() const { return names_first ? 12 : 6; }

  /// Root mean square of what a cause must add to be worth a name [rad or m]. Near an edge a reading tells
  /// more than a noisy reference knows: what repeats there has the size of that noise.
  double least(const Evidence& e) const { return std::max(0.05 * e.step(), 0.5 * e.noise); }
  /// The same of one that was looked for over a range of orders, times or frequencies.
  double least_scanned(const Evidence& e) const { return std::max(0.1 * e.step(), 1.0 * e.noise); }
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
