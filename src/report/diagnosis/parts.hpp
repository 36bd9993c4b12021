#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "qerr/report/diagnosis_report.hpp"
#include "qerr/report/write.hpp"
#include "report/rows.hpp"

/// What the formats and files of a diagnosis share.
namespace qerr {

/// Index of the independent joint of this name, and of its encoder; empty if unknown.
std::optional<std::size_t> joint_place(const Spec&, const std::string& name);

/// Null if no joint has this name.
const Encoder* encoder_of(const Spec&, const std::string& joint);

/// SI unit of a figure of an unidentified error, "" for a pure number.
std::string figure_unit(const Spec&, const Unidentified&, const std::string& figure);

/// A figure with its 95 % interval, rounded to two digits of the interval: `566.1 +- 2.9 urad`; with an
/// asymmetric interval `566 urad (540 urad .. 570 urad)`; phases in degrees; without an interval if the
/// parameter was not fitted.
std::string with_interval(const ReportedParameter&);

RowsOf<Gain> rows(Of<Gain>);

}  // namespace qerr
