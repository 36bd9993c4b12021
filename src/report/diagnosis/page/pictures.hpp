#pragma once

#include <cstddef>
#include <string>

#include "qerr/report/diagnosis_report.hpp"

/// The parts of the page of a diagnosis, as markup; each "" if there is nothing to show.
namespace qerr {

/// Each cause with its size, remedy and alternatives, and its residual with the fit.
std::string causes_part(const DiagnosisReport&);

/// The parameters of all causes: a table, and the sizes of one unit as bars with 95 % intervals.
std::string parameters_part(const DiagnosisReport&);

/// Measured - reference of each joint before and after subtraction of the causes.
/// @param points  of all its lines together, about
std::string residuals_part(const DiagnosisReport&, std::size_t points);

/// What no cause explains, and what to do about it.
std::string remainder_part(const DiagnosisReport&);

/// Faults of the record itself.
std::string record_part(const DiagnosisReport&);

/// The smallest effects that the record would have shown, and those that its motion hid.
std::string visible_part(const DiagnosisReport&);

/// Rms before and after.
std::string gain_part(const DiagnosisReport&);

/// The curve with the fit, if it has one; "" without a curve.
/// @param joint  or coordinate of the tip
std::string curve_figure(const Spec&, const std::string& title, const std::string& joint,
                         const ResidualCurve&);

}  // namespace qerr
