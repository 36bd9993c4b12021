#pragma once

#include <string>

#include "qerr/diagnose/diagnosis.hpp"

namespace qerr {

/// `eccentricity of elbow`; a periodic error with its order.
std::string label(const Cause&);

/// The sentence behind the verdict: the causes and their joints.
std::string verdict_words(const Diagnosis&);

}  // namespace qerr
