#pragma once

#include <vector>

#include "diagnose/inference/tip/tip_model.hpp"

namespace qerr {

struct TipSelectOptions {
  double alpha = 0.01;            ///< of a false name in the record, over all candidates
  double least_amplitude = 0.15;  ///< rms of what a cause adds, over that of all noise at the tip
  std::size_t most_terms = 24;
};

/// What could stand in a chosen term's place almost as well.
struct TipAlternative {
  std::size_t term = 0;
  TipTerm other;
  double loss = 0;          ///< of log-likelihood against the chosen one
  bool everywhere = false;  ///< no pose tells them apart
};

struct TipSelection {
  TipModel model;
  std::vector<double> p_values;  ///< of each term against the model without it
  std::vector<TipAlternative> alternatives;
  std::vector<TipTerm> tilts;  ///< axes that stand askew on top of it: real, but of no name
  std::vector<Eigen::VectorXd> tilt_sizes;
};

/// Names what the record of a tracked tip asks for: forward by likelihood among the terms that pass their
/// test, each one in the model as the others have become with it; then what stopped to matter is dropped and
/// each term is tried against every other one. The tracker's frames are fitted only where the record asks for
/// them too.
TipSelection select_tip(const OperationalModel&, const TipEvidence&, std::uint64_t seed,
                        const TipSelectOptions& = {});

}  // namespace qerr
