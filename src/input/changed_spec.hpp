#pragma once

#include <string>
#include <vector>

#include "input/override.hpp"
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

}  // namespace qerr
