#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "gain.hpp"
#include "qerr/diagnose/evidence.hpp"
#include "qerr/diagnose/sanity.hpp"
#include "scatter.hpp"
#include "select.hpp"

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
