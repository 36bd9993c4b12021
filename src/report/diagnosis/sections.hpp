#pragma once

#include <string>
#include <vector>

#include "qerr/report/diagnosis_report.hpp"
#include "qerr/report/write.hpp"

/// The sections of the table of a diagnosis, each "" if there is nothing to report.
namespace qerr {

/// Appends an item that the list does not have yet.
void add_once(std::vector<std::string>& list, const std::string& item);

/// A size for people: `5.49 counts = 400 urad = 1.38 arcmin`.
/// @param unit     rad or m
/// @param encoder  of the counts; null: none
std::string size_text(double value, const std::string& unit, const Encoder* encoder);

/// An angle in deg, arcmin or arcsec, whichever is between 1 and 60.
std::string arc_text(double angle);

/// The faults of the record itself, each with its place and remedy.
std::string data_section(const DiagnosisReport&, const Style&);

/// The causes: size, what is lost without it, remedy, alternatives, picture.
std::string causes_section(const DiagnosisReport&, const Style&);

/// The residual of the extended model, and the shapes in it that no effect has.
std::string remainder_section(const DiagnosisReport&, const Style&);

/// What to inspect or to record for each shape in the residual.
std::string next_section(const DiagnosisReport&, const Style&);

/// The smallest effects that the record would have shown, and those that its motion hid.
std::string visible_section(const DiagnosisReport&, const Style&);

/// Statistics, intervals, p-values and gains.
std::string details_section(const DiagnosisReport&, const Style&);

/// `a step of 37.4 counts = 2.73 mrad = 9.39 arcmin at 9.00 s`.
std::string shape_words(const Spec&, const Unidentified&);

/// What to inspect or to record to find the cause of a shape.
std::string shape_advice(Shape);

/// The curve as a picture, in counts where the joint has an encoder; "" without a curve.
std::string curve_picture(const Spec&, const std::string& joint, const ResidualCurve&, const Style&);

/// The joint, or `tip`, whose residual the cause's gain refers to.
std::string place_of(const Cause&);

}  // namespace qerr
