#pragma once

#include <string>
#include <vector>

#include "input/override.hpp"
#include "input/yaml_tree.hpp"
#include "qerr/input/spec.hpp"

namespace qerr {

/// The text of a spec with its overrides and further changes written into it; comments and layout of the rest
/// are kept.
/// @param effects  entries that are added to `effects:`; one of the same type and joint is replaced
/// @param remark   a comment at its end
/// @param target   path at which the text will stand, for its paths
/// @throws Error (input), with the place, if the layout of the text does not allow a change
std::string changed_spec(const Spec&, const std::vector<SpecChange>& changes,
                         const std::vector<Node>& effects, const std::string& remark,
                         const std::string& target);

/// Rewrites the paths of a spec's tree, which are relative to the spec, for a spec that stands elsewhere.
/// @param from, to  paths of the specs; `-` is in the working folder
void move_paths(Node& root, const std::string& from, const std::string& to);

}  // namespace qerr
