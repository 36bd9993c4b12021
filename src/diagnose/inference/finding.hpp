#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "diagnose/inference/scatter.hpp"
#include "diagnose/inference/select.hpp"
#include "diagnose/record/evidence.hpp"
#include "diagnose/record/sanity.hpp"
#include "diagnose/verdict/gain.hpp"

namespace qerr {

/// What the rows of one encoder say.
struct Finding {
  Evidence evidence;  ///< its independent rows
  std::optional<Selection> selection;
  Scatter scatter;
  HeldOut held;
};

/// Every encoder by itself, side by side; then those that feel other joints too (coupling), with what was
/// found at these.
/// @param all  evidence of the repaired log, with the effects that the spec has
std::vector<std::unique_ptr<Finding>> findings_of(std::vector<Evidence> all, const Sanity&,
                                                  const DiagnoseOptions&);

}  // namespace qerr
