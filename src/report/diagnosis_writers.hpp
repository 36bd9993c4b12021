#pragma once

#include <string>

#include "qerr/report/diagnosis_report.hpp"
#include "qerr/report/write.hpp"

/// What the formats offer to diagnosis_report.cpp, one function per format.
namespace qerr {

std::string to_json(const DiagnosisReport&);
std::string to_csv(const DiagnosisReport&);
std::string to_table(const DiagnosisReport&, const Style&);

/// The unit of the gain over all joints.
inline std::string gain_unit(const Diagnosis& d) { return d.prismatic ? "m" : "rad"; }

}  // namespace qerr
