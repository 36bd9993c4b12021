#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "qerr/bound/figure.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/kinematics/robot_model.hpp"

namespace qerr {

/// Upper bound of a figure of the model over the box of the joint ranges: never exceeded, rounding included.
///
/// Dynamic programming along the chain: position_sigma.hpp (xyz), component_sigma.hpp,
/// position_worst_case.hpp, rotation_bound.hpp, tip_component.hpp. The bound converges to the largest figure
/// as the grids are refined, also with errors that move two neighbours (differentials), and for the worst
/// case with errors that move any joints (the signs of at most 7 errors of distant joints are tried). For
/// sigma such distant errors are relaxed to independent ones unless there is no other error: the bound holds,
/// but a gap remains. Joints that mimic one another are independent within parts of their master's range, at
/// most 400 parts.
/// @param figure       worst_case or sigma of the position, of a coordinate or length
/// @param ranges       one per independent joint [rad or m]
/// @param known_lower  a value of the figure that is reached in the box
/// @param gap          the grid is refined until bound <= known_lower (1 + gap), or to a finest grid that
///   depends on `gap` only
/// @returns empty where the method does not apply (Euler angles, infinite ranges, more errors of distant
/// joints)
std::optional<double> chain_upper_bound(const OperationalModel&, const std::vector<Limits>& ranges,
                                        const Figure& figure, double known_lower, double gap);

}  // namespace qerr
