#pragma once

#include <string>
#include <vector>

#include "qerr/input/spec.hpp"

namespace qerr {

/// Limits of the command line, `position.xyz.worst_case=50 um`: bounds of coordinates and their highest
/// values. Lengths that the spec does not have are added to its coordinates.
/// @param option  that the messages name
/// @throws Error (usage)
std::vector<Requirement> read_limits(const std::string& option, const std::vector<std::string>& texts, Spec&);

}  // namespace qerr
