#pragma once

#include <string>

#include "qerr/diagnose/diagnosis.hpp"

namespace qerr {

/// A name from a file, as a terminal may show it.
std::string shown(const std::string& name);

/// `eccentricity of elbow`; periodic errors are told from each other by their order.
std::string label(const Cause&);

/// What follows the verdict: in a sentence, what was found and where.
std::string verdict_words(const Diagnosis&);

}  // namespace qerr
