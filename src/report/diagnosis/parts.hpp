#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "qerr/report/diagnosis_report.hpp"
#include "qerr/report/write.hpp"

/// What the formats and files of a diagnosis share.
namespace qerr {

/// Index of the independent joint of this name, and of its encoder; empty if unknown.
std::optional<std::size_t> joint_place(const Spec&, const std::string& name);

/// A figure with its 95 % interval, rounded to two digits of the interval: `566.1 +- 2.9 urad`; with an
/// asymmetric interval `566 urad (540 urad .. 570 urad)`; phases in degrees; without an interval if the
/// parameter was not fitted.
std::string with_interval(const ReportedParameter&);

}  // namespace qerr
