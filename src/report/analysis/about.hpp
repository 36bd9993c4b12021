#pragma once

#include <optional>
#include <string>
#include <vector>

#include "qerr/design/requirement.hpp"
#include "qerr/input/spec.hpp"
#include "report/page/page.hpp"

namespace qerr::page {

/// What a page is about: its spec with hash and overrides, the encoders, and the verdict of each requirement.
/// @param results  of the spec's requirements; empty: the page does not judge them
/// @param caption  whose results they are, if not those of the spec itself
std::string title_block(const Spec&, const std::optional<std::vector<RequirementResult>>& results,
                        const std::string& caption = "");

/// The title block at the head of a page, and the spec's text at its end.
void describe(Page&, const Spec&, const std::optional<std::vector<RequirementResult>>& results,
              const std::string& caption = "");

/// Each requirement with its verdict, value, margin, the part of its limit that is used, the configuration
/// where its quantity is largest and, with overrides, its value without them.
std::string requirement_table(const Spec&, const std::vector<RequirementResult>& results,
                              const std::string& caption = "");

}  // namespace qerr::page
