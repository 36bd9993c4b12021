#pragma once

#include <functional>
#include <vector>

#include "diagnose/record/evidence.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "qerr/report/diagnosis_report.hpp"

namespace qerr {

/// The reading of an encoder with effects, without quantization, backlash and random effects: the actions of
/// the effects in the order of the signal's stages.
class ExtendedReading {
 public:
  /// @param effects  backlash, random effects, effects on the log and those without a row are ignored
  ExtendedReading(const std::vector<Effect>& effects, const Encoder&);

  /// Time at which the reading with this time stamp was sampled [s].
  double sampled_at(double time) const;

  /// The reading. @param position  the true one at the time of sampling [rad or m]
  double operator()(double position, const Moment&) const;

  /// Position that the reference sensor reports [rad or m].
  double reference(double position, const Moment&) const;

 private:
  struct Step {
    Stage stage;
    Action action;
  };
  std::vector<Step> steps_;
  double resolution_;
};

/// The contribution of the effects to measured - reference in each row, backlash included [rad or m].
Eigen::ArrayXd explained(const Evidence&, const std::vector<Effect>&);

/// Whether a look-up table can compensate an effect: its error is a smooth function of the position alone.
bool fits_table(const Effect&);

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
