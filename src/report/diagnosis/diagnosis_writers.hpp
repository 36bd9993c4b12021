#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "qerr/report/diagnosis_report.hpp"
#include "qerr/report/write.hpp"

/// What the formats offer to diagnosis_report.cpp, one function per format.
namespace qerr {

std::string to_json(const DiagnosisReport&);
std::string to_csv(const DiagnosisReport&);
std::string to_table(const DiagnosisReport&, const Style&);

/// Number of the independent joint of this name, and of its encoder; empty where there is none.
std::optional<std::size_t> joint_place(const Spec&, const std::string& name);

/// A figure with its 95 % interval, to the digits that it is known to: `566.1 +- 2.9 urad`; where the
/// interval is not about the figure, `566 urad (540 urad .. 570 urad)`; phases in degrees; the figure alone
/// where it was not fitted.
std::string with_interval(const ReportedParameter&);

}  // namespace qerr
