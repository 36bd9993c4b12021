#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "qerr/report/diagnosis_report.hpp"
#include "report/diagnosis/joint_residual.hpp"

namespace qerr {

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

/// The parts of the page of a diagnosis, as markup; each "" if there is nothing to show.

/// Each cause with its size, remedy and alternatives, and its residual with the fit.
std::string causes_part(const DiagnosisReport&);

/// The parameters of all causes with their 95 % intervals, and how sure each cause is.
std::string parameters_part(const DiagnosisReport&);

/// Measured - reference of each joint before and after subtraction of the causes.
/// @param bytes  that it may take, about: joints beyond are named, but not drawn
std::string residuals_part(const DiagnosisReport&, std::size_t bytes);

/// What no cause explains.
std::string remainder_part(const DiagnosisReport&);

/// What to record or to inspect next, and what the motion of this record hides.
std::string next_part(const DiagnosisReport&);

/// Faults of the record itself.
std::string record_part(const DiagnosisReport&);

/// The smallest effects that the record would have shown.
std::string visible_part(const DiagnosisReport&);

/// Rms before and after.
std::string gain_part(const DiagnosisReport&);

/// Whether the curves of all causes, and of what remains, may have marks, each of which takes as many bytes
/// as five points of a line.
bool has_few_curves(const Diagnosis&);

/// The curve with the fit, if it has one; "" without a curve.
/// @param joint  or coordinate of the tip
/// @param marks  the residual as marks, else as a line
std::string curve_figure(const Spec&, const std::string& title, const std::string& joint,
                         const ResidualCurve&, bool marks);

}  // namespace qerr
