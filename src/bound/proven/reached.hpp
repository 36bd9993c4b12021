#pragma once

#include "qerr/bound/proven_maximum.hpp"

namespace qerr {

/// Sets `lower` to a value that is reached.
/// @throws std::logic_error if it contradicts the proof: exceeds `upper` by more than 1e-9 of it
void set_reached(ProvenMaximum&, double value);

}  // namespace qerr
