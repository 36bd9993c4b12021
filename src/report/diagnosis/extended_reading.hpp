#pragma once

#include <vector>

#include "diagnose/record/evidence.hpp"
#include "qerr/effect/effect_kind.hpp"

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

}  // namespace qerr
