#pragma once

#include <vector>

#include "input/yaml_tree.hpp"
#include "qerr/input/spec.hpp"

namespace qerr {

/// Writes filters into the `filters:` of a spec's tree.
///
/// A filter of the same name keeps everything but its low-pass; a new one has derivative and sample rate of
/// the first filter that estimates a velocity.
void add_filters(Node& root, const std::vector<NamedFilter>& present, const std::vector<AddedFilter>&);

}  // namespace qerr
