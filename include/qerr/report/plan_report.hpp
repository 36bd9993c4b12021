#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "qerr/diagnose/plan.hpp"
#include "qerr/input/spec.hpp"

namespace qerr {

/// The result of `qerr diagnose --plan`.
struct PlanReport {
  Spec spec;
  Plan plan;
  std::vector<std::string> warnings;
};

/// The effects that a log of the spec's motion would detect and identify.
/// @throws Error (input; key `motion`) if the spec has none
PlanReport plan_report(const Spec&, const PlanOptions& = {});

/// The `motion:` section of a spec, with a motion of each joint.
std::string motion_text(const Motion&, const Chain&);

}  // namespace qerr
