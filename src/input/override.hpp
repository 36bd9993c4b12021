#pragma once

#include <string>
#include <utility>
#include <vector>

#include "input/yaml_tree.hpp"

namespace qerr {

/// A change of a spec: a dotted path, and its value, whose place is that of the change in messages.
using SpecChange = std::pair<std::string, Node>;

/// Replaces or adds the value at a dotted path (`filters.velocity.derivative`); items of lists are counted
/// from zero, `requirements.0.at_most` or `requirements[0].at_most`. Where keys contain dots, the longest
/// matching key is used.
///
/// A joint without an entry of its own under `encoders` or `configurations.limits` first gets a copy of what
/// holds for it, the entry of a pattern. In an encoder's entry the key of a kind (`bits`) removes those that
/// it excludes (`counts_per_rev`, `decoding`).
/// @throws Error (input) if the path passes through a single value or beyond the end of a list, would begin
/// a new filter with one of its keys
void apply_override(Node& root, const SpecChange&);

/// The change of a path to the value of a YAML text.
/// @param origin  place of the change in messages, such as `--set KEY`
/// @throws Error (input) if the text is not YAML
SpecChange spec_change(const std::string& path, const std::string& text, const std::string& origin);

/// The changes of --set, in the order of the command line.
std::vector<SpecChange> spec_changes(const std::vector<std::pair<std::string, std::string>>& set);

/// The order in which several changes are applied: changes of a pattern's entry (`encoders.*.gear_ratio`)
/// before those of single joints, which begin with a copy of it, so that their order on the command line does
/// not matter. A change of the whole section keeps its place.
std::vector<SpecChange> in_order(std::vector<SpecChange> changes);

}  // namespace qerr
