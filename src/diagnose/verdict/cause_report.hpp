#pragma once

#include "diagnose/inference/finding.hpp"
#include "qerr/diagnose/diagnosis.hpp"

namespace qerr {

/// Puts one encoder's causes, alternatives and remainders into the diagnosis.
/// @param gain    of its joint
/// @param loaded  the joint's own weight can turn it
void add(Diagnosis&, const Finding&, const Gain& gain, bool loaded);

/// Whether a joint's own weight can turn it: where its axis is not upright.
bool feels_gravity(const OperationalModel&, const Log&, Eigen::Index joint);

}  // namespace qerr
