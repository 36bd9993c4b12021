#pragma once

#include <vector>

#include "diagnose/inference/explanation.hpp"

namespace qerr {

struct SelectOptions {
  double alpha = 0.01;  ///< of a false name in one encoder's record, over all candidates
  /// For records that named terms explain almost completely: their residual is first searched for named
  /// terms.
  bool names_first = false;

  std::size_t most_terms() const { return names_first ? 12 : 6; }

  /// Smallest rms of a term that is reported [rad or m]. Readings near an edge resolve less than the noise of
  /// the reference, so that errors of the reference's size appear in them.
  double least(const Evidence& e) const { return std::max(0.05 * e.step(), 0.5 * e.noise); }
  /// The same of a term found by a scan over orders, times or frequencies.
  double least_scanned(const Evidence& e) const { return std::max(0.1 * e.step(), 1.0 * e.noise); }
};

/// A term that could replace a chosen one.
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

/// Selects the terms of an encoder's record: forward by likelihood among those that pass their test, then
/// backward elimination, then comparison of each term with every other one.
Selection select(const Evidence&, const SelectOptions& = {});

}  // namespace qerr
