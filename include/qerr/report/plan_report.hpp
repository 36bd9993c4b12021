#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "qerr/diagnose/plan.hpp"
#include "qerr/input/spec.hpp"

namespace qerr {

/// The answer of `qerr diagnose --plan`.
struct PlanReport {
  Spec spec;
  Plan plan;
  std::vector<std::string> warnings;
};

/// What a record of the spec's motion could show.
/// @throws Error (input; key `motion`) when the spec has none
PlanReport plan_report(const Spec&, const PlanOptions& = {});

/// `motion:` as it stands in a spec, of a motion whose joints are written out.
std::string motion_text(const Motion&, const Chain&);

}  // namespace qerr
