#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "diagnose/inference/gain.hpp"
#include "diagnose/inference/remainder.hpp"
#include "diagnose/inference/scatter.hpp"
#include "diagnose/inference/selection.hpp"
#include "diagnose/inference/simulated_fit.hpp"
#include "diagnose/record/evidence.hpp"
#include "diagnose/record/sanity/sanity.hpp"

namespace qerr {

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

/// Every encoder by itself, side by side; then those that feel other joints too (coupling), with what was
/// found at these.
/// @param all  evidence of the repaired log, with the effects that the spec has
std::vector<std::unique_ptr<Finding>> findings_of(std::vector<Evidence> all, const Sanity&,
                                                  const DiagnoseOptions&);

}  // namespace qerr
