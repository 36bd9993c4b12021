#pragma once

#include <string>

#include "qerr/bound/effect_shares.hpp"
#include "qerr/bound/independent_error.hpp"
#include "qerr/input/spec.hpp"

namespace qerr {

/// What slow errors of unknown shape pass behind the filters, if they are sines of the encoder's shaft and of
/// unknown phase: one period a revolution, as of an eccentric disc or magnet, and of a gear two, as of a
/// strain wave's (Tuttle and Seering, IEEE Trans. Robotics and Automation 12(3), 1996). A scale without a
/// shaft has one period over the joint's range.
struct SlowErrorRatios {
  SigmaRatios accuracy, gear_accuracy;
};

/// Along the spec's motion the mean square of the filtered sine, over the samples after the settling and over
/// the phases; without a motion the mean of |H(f)|^2 over the speeds from 0 to the URDF's limits, all equally
/// probable. NaN where neither is known, and of a motion of more than `longest_record` samples.
SlowErrorRatios slow_error_ratios(const Spec&);

/// [filter]: T sum s_k^2 of the step response s, the energy of a step of 1 behind the filter [s^(1 - 2d)]; of
/// one that does not come back to 0, or not within a million samples, NaN.
std::vector<double> step_energies(const std::vector<Filter>&);

/// How slow errors behind the filters are judged, in a sentence; "" if there are none, or they are not known.
std::string slow_error_assumption(const Spec&, const std::vector<EffectShare>&);

}  // namespace qerr
