#pragma once

#include <functional>
#include <vector>

#include "diagnose/record/evidence.hpp"
#include "qerr/report/diagnosis_report.hpp"

namespace qerr {

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

}  // namespace qerr
