#pragma once

#include <string>
#include <vector>

#include "qerr/effect/effect.hpp"
#include "qerr/input/spec.hpp"

namespace qerr {

/// The text of the spec's URDF with the link dimensions of effects `geometry`, stated and found: each moves
/// the <origin> of its joint in the frame of the parent link. All else is as in the file.
/// @throws Error (input) where the robot is not from a URDF, or the file cannot be read
/// @param found  beside those that the spec states
std::string urdf_as_built(const Spec&, const std::vector<Effect>& found);

}  // namespace qerr
