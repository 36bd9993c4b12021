#pragma once

#include "diagnose/inference/finding.hpp"
#include "qerr/diagnose/diagnosis.hpp"

namespace qerr {

/// Adds one encoder's causes, their alternatives and its unexplained errors to the diagnosis.
/// @param gain  of its joint
void add(Diagnosis&, const Finding&, const Gain& gain);

}  // namespace qerr
