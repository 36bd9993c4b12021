#pragma once

#include <vector>

#include "diagnose/record/evidence.hpp"
#include "qerr/effect/effect.hpp"

namespace qerr {

/// What an encoder with effects reads, its quantization, backlash and everything random left out: the
/// effects' actions one after the other, in the order in which the signal passes them.
class ExtendedReading {
 public:
  /// @param effects  those that no row knows, backlash, random ones and those of the file are passed over
  ExtendedReading(const std::vector<Effect>& effects, const Encoder&);

  /// When a reading of this time was taken [s].
  double taken(double time) const;

  /// @param position  true one, when the reading was taken [rad or m]
  double operator()(double position, const Moment&) const;

  /// What the better sensor says of it [rad or m].
  double reference(double position, const Moment&) const;

 private:
  struct Step {
    Stage stage;
    Action action;
  };
  std::vector<Step> steps_;
  double resolution_;
};

/// What the effects add to measured - reference, row by row, backlash included [rad or m].
Eigen::ArrayXd explained(const Evidence&, const std::vector<Effect>&);

/// Whether the error of an effect depends on the position alone and changes smoothly with it: a look-up table
/// can hold it.
bool fits_table(const Effect&);

}  // namespace qerr
