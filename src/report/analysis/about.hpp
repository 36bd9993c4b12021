#pragma once

#include <optional>
#include <vector>

#include "qerr/design/requirement.hpp"
#include "qerr/input/spec.hpp"
#include "report/page/bars.hpp"
#include "report/page/page.hpp"

namespace qerr::page {

/// What a page is about: its spec with hash and overrides, the encoders, and the verdict of each requirement.
/// @param results  of the spec's requirements; empty: the page does not judge them
void describe(Page&, const Spec&, const std::optional<std::vector<RequirementResult>>& results);

/// A bar for each requirement: the part of its limit that is used. Only the limit's own bar if none has one.
Bars use_of_limits(const std::vector<Requirement>&, const std::vector<RequirementResult>&);

}  // namespace qerr::page
