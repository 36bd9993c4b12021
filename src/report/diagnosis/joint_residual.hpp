#pragma once

#include <array>
#include <functional>
#include <string>
#include <utility>
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
