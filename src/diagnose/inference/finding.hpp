#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "diagnose/inference/explanation.hpp"
#include "diagnose/inference/gain.hpp"
#include "diagnose/inference/remainder.hpp"
#include "diagnose/inference/scatter.hpp"
#include "diagnose/inference/simulated_fit.hpp"
#include "diagnose/record/evidence.hpp"
#include "diagnose/record/sanity/sanity.hpp"
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

/// The result of the inference for one encoder. Not copyable: the model of `selection` points to the
/// sampling's evidence.
struct Finding {
  std::optional<Sampling> sampling;  ///< its independent rows
  std::optional<Selection> selection;
  std::vector<VisibleEffect> visible;
  Scatter scatter;
  Remainder remainder;
  HeldOut held;
  SimulatedReadings simulated;  ///< with the causes found

  const Evidence& evidence() const { return sampling->evidence; }

  Finding() = default;
  Finding(const Finding&) = delete;
  Finding& operator=(const Finding&) = delete;
};

/// Whether the causes of an encoder's error have a gear that an effort deflects against itself.
bool has_reversed_effort(const Evidence&, std::uint64_t seed);

/// Every encoder by itself, side by side; then those that feel other joints too (coupling), with what was
/// found at these.
/// @param all  evidence of the repaired log, with the effects that the spec has
std::vector<std::unique_ptr<Finding>> findings_of(std::vector<Evidence> all, const Sanity&,
                                                  const DiagnoseOptions&);

}  // namespace qerr
