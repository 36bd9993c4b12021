#pragma once

#include <string>

#include "qerr/report/diagnosis_report.hpp"

namespace qerr {

/// `eccentricity of elbow`; a periodic error with its order.
std::string label(const Cause&);

/// `NOTHING WRONG`, or, if the record itself has faults, `NOTHING WRONG, BUT CORRUPT READINGS`.
std::string verdict_title(const Diagnosis&);

/// The sentence behind the verdict: the causes and their joints; a single remainder by its shape.
std::string verdict_words(const DiagnosisReport&);

}  // namespace qerr
