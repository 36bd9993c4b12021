#pragma once

#include <string>
#include <utility>
#include <vector>

#include "input/yaml_tree.hpp"

namespace qerr {

/// Replaces or adds the value at a dotted path (`filters.velocity.derivative`); items of lists are counted
/// from zero, `requirements.0.at_most` or `requirements[0].at_most`. Where keys contain dots, the longest
/// matching key is used.
///
/// A joint without an entry of its own under `encoders` or `configurations.limits` first gets a copy of what
/// holds for it, the entry of a pattern. In an encoder's entry the key of a kind (`bits`) removes those that
/// it excludes (`counts_per_rev`, `decoding`).
/// @param value   YAML text of the new value
/// @param origin  place of the change in messages, such as `--set KEY`
/// @throws Error (input) if the path passes through a single value or beyond the end of a list, would begin
/// a new filter with one of its keys, or if the value is not YAML
void apply_override(Node& root, const std::string& path, const std::string& value, const std::string& origin);

/// The order in which several overrides are applied: changes of a pattern's entry (`encoders.*.gear_ratio`)
/// before those of single joints, which begin with a copy of it, so that their order on the command line does
/// not matter. A change of the whole section keeps its place.
std::vector<std::pair<std::string, std::string>> in_order(
    std::vector<std::pair<std::string, std::string>> overrides);

}  // namespace qerr
