#pragma once

#include "qerr/effect/effect.hpp"

namespace qerr {

// What effects of the form amplitude * sin(order * shaft angle + phase) share.
Parameter periodic_amplitude();
Parameter periodic_phase();
Parameter periodic_shaft();
Action periodic_action(const Effect&, const Encoder&, std::uint64_t seed);
std::optional<Share> periodic_share(const Effect&, const Encoder&, const Usage&);

}  // namespace qerr
