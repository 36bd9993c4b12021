#pragma once

#include <vector>

#include "diagnose/inference/tip/tip_model.hpp"

namespace qerr {

/// Number of orders and times that a scan at the tip tests, for the correction of its p-value.
inline constexpr int scanned_at_tip = 600;

/// What the model may be extended by: the catalogue, tilts of axes, and what a scan of the present scores
/// suggests. Nothing that it has.
std::vector<TipTerm> tip_candidates(const TipModel&);

/// Whether the model has this cause already.
bool chosen(const TipModel&, const TipTerm&);

struct TipSelectOptions {
  double alpha = 0.01;            ///< of a false name in the record, over all candidates
  double least_amplitude = 0.15;  ///< rms of what a cause adds, over that of all noise at the tip
  std::size_t most_terms = 24;
  bool tracker = false;  ///< whether it may have been displaced during the record (`tracker_terms`)
};

/// A term that could replace a chosen one.
struct TipAlternative {
  std::size_t term = 0;
  TipTerm other;
  double loss = 0;          ///< of log-likelihood against the chosen one
  bool everywhere = false;  ///< no pose distinguishes them
};

struct TipSelection {
  TipModel model;
  std::vector<double> p_values;  ///< of each term against the model without it
  std::vector<TipAlternative> alternatives;
};

/// Selects the terms of a tracked tip: forward by likelihood among those that pass their test, with a refit
/// after each; then backward elimination and comparison of each term with every other one. The tracker's
/// frames are fitted only where they are significant.
TipSelection select_tip(const OperationalModel&, const TipEvidence&, std::uint64_t seed,
                        const TipSelectOptions& = {});

/// Replaces chosen terms by better ones until none is better, then lists the terms that fit as well.
void find_tip_alternatives(const OperationalModel&, TipSelection&);

}  // namespace qerr
