#pragma once

#include <string>

#include "input/yaml_tree.hpp"

namespace qerr {

/// Rewrites the paths of a spec's tree, which are relative to the spec, for a spec that stands elsewhere.
/// @param from, to  paths of the specs; `-` is in the working folder
void move_paths(Node& root, const std::string& from, const std::string& to);

}  // namespace qerr
