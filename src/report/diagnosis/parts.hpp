#pragma once

#include <array>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "diagnose/record/evidence.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "qerr/report/diagnosis_report.hpp"
#include "qerr/report/write.hpp"
#include "report/rows.hpp"
#include "report/text_table.hpp"

/// What the formats and files of a diagnosis share.
namespace qerr {

/// Null if no joint has this name.
const Encoder* encoder_of(const Spec&, const std::string& joint);

/// SI unit of a figure of an unidentified error, "" for a pure number.
std::string figure_unit(const Spec&, const Unidentified&, const std::string& figure);

/// A figure with its 95 % interval, rounded to two digits of the interval: `566.1 +- 2.9 urad`; with an
/// asymmetric interval `566 urad (540 urad .. 570 urad)`; phases in degrees; without an interval if the
/// parameter was not fitted.
std::string with_interval(const ReportedParameter&);

RowsOf<Gain> rows(Of<Gain>);

/// The sections of the table of a diagnosis, each "" if there is nothing to report.

/// An angle in deg, arcmin or arcsec, whichever is between 1 and 60.
std::string arc_text(double angle);

/// The causes: size, what is lost without it, remedy, alternatives, picture.
std::string causes_section(const DiagnosisReport&, const Style&);

/// The smallest effects that the record would have shown, and those that its motion hid.
std::string visible_section(const DiagnosisReport&, const Style&);

/// What the sections are made of, for other formats too.

/// `'log.csv': 5000 rows over 10 s`, and which columns were unwrapped.
std::string record_words(const Log&);

/// `gap 400.03 +- 0.11 urad = 1.38 arcmin = 5.49 counts`: the parameters and choices of a cause.
std::string size_words(const DiagnosisReport&, const Cause&);

/// What is lost without the cause; where that is unknown, what all causes of its place remove together.
std::string loss_words(const DiagnosisReport&, const Cause&);

/// Alternatives to the cause (null: to what is no cause of the list), those with the same advice together:
/// `latency and timing_jitter; to tell them apart, record ...`.
std::vector<std::string> alternatives_to(const Diagnosis&, const Cause*);

/// A parameter with its interval, and a coordinate also in counts.
std::string parameter_size(const Spec&, const Cause&, const ReportedParameter&);

/// The residual of the extended model: one line per joint with a cause, or for the tip; without causes one
/// for all joints.
std::vector<std::string> remainder_lines(const Diagnosis&);

/// What to inspect or to record, once for each shape.
std::vector<std::string> advice_lines(const Diagnosis&);

/// Rms of the residual before and after, in units and counts: a header and a row for each place.
TableRows gain_rows(const Diagnosis&);

/// How well the extended model predicts each reading.
std::vector<std::string> prediction_lines(const Gain&);

/// The smallest visible sizes under a header: effects as rows, joints as columns, without those in which
/// nothing is visible.
TableRows visible_sizes(const Diagnosis&);

/// One line for all effects of a joint that are hidden for the same reason.
std::vector<std::string> hidden_lines(const Diagnosis&);

/// `j1, row 17`.
std::string place_of(const DataFinding&);

/// `a step of 37.4 counts = 2.73 mrad = 9.39 arcmin at 9.00 s`.
std::string shape_words(const Spec&, const Unidentified&);

/// The curve as a picture, in counts where the joint has an encoder; "" without a curve.
std::string curve_picture(const Spec&, const std::string& joint, const ResidualCurve&, const Style&);

/// The joint, or `tip`, whose residual the cause's gain refers to.
std::string place_of(const Cause&);

/// `eccentricity of elbow`; a periodic error with its order.
std::string label(const Cause&);

/// `NOTHING WRONG`, or, if the record itself has faults, `NOTHING WRONG, BUT CORRUPT READINGS`.
std::string verdict_title(const Diagnosis&);

/// The sentence behind the verdict: the causes and their joints; a single remainder by its shape.
std::string verdict_words(const DiagnosisReport&);

/// measured - reference of one encoder in every row, as recorded, and after subtraction of the effects found
/// [rad or m].
struct JointResidual {
  Evidence evidence;
  Eigen::ArrayXd before, after;
};

/// Calls `task` for each encoder whose joint has a reference, with its number. Several calls at a time, and
/// as many encoders as have some million rows, so that memory does not grow with their number.
/// @pre the report's log has its values, or there is no call
void for_each_residual(const DiagnosisReport&, const std::function<void(const JointResidual&)>& task);

/// Amplitude of the sine of each order of the joint's position, of the means in equal intervals of its range.
struct PositionSpectrum {
  std::vector<double> order;          ///< per revolution of the joint, or per metre
  std::vector<double> encoder_order;  ///< per revolution of the encoder
  std::vector<double> before, after;  ///< [rad or m]
};

/// Empty if the joint does not move.
PositionSpectrum position_spectrum(const JointResidual&);

/// What the page draws of a joint's residual, with few points [SI].
struct ResidualPicture {
  using Points = std::vector<std::pair<double, double>>;

  std::string joint, unit;
  double resolution = 0;  ///< of the encoder [unit]
  bool prismatic = false, in_time = false;
  Eigen::Index rows = 0;
  double rms_before = 0, rms_after = 0;
  bool corrected = false;  ///< a cause was subtracted
  Points before, after;    ///< over time, or over the row
  struct Side {            ///< rows with one direction of the motion
    Points before, after;  ///< over the reference's position
    Points fit, mean;      ///< mean of what was subtracted, and of what was before
  };
  std::array<Side, 3> sides;               ///< forward, backward, unknown
  Points by_count_before, by_count_after;  ///< means, over the count modulo `count_cycle`
  Points spectrum_before, spectrum_after;  ///< amplitude over the order
  double revolution = 0;                   ///< order of one period per revolution of the encoder
};

/// Readings with the same remainder have the same state of a line's signals and the same last bits.
inline constexpr int count_cycle = 64;

/// @param intervals  of each line
ResidualPicture residual_picture(const JointResidual&, std::size_t intervals);

}  // namespace qerr
