#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "qerr/report/diagnosis_report.hpp"
#include "qerr/report/write.hpp"

/// What the formats and files of a diagnosis share.
namespace qerr {

/// Number of the independent joint of this name, and of its encoder; empty where there is none.
std::optional<std::size_t> joint_place(const Spec&, const std::string& name);

/// A figure with its 95 % interval, to the digits that it is known to: `566.1 +- 2.9 urad`; where the
/// interval is not about the figure, `566 urad (540 urad .. 570 urad)`; phases in degrees; the figure alone
/// where it was not fitted.
std::string with_interval(const ReportedParameter&);

}  // namespace qerr
