#pragma once

#include <optional>
#include <string>
#include <vector>

#include "control/control.hpp"
#include "qerr/bound/effect_shares.hpp"
#include "qerr/bound/independent_error.hpp"
#include "qerr/input/spec.hpp"
#include "qerr/report/analysis.hpp"
#include "qerr/report/write.hpp"

namespace qerr {

/// Ranges of position, speed and effort of each joint, on which the effects depend: those of the spec's
/// motion. Without a motion, and for efforts of a robot without masses, the sampled range of each joint and
/// the URDF's limits of velocity and effort.
RobotUsage usage_of(const Spec&);

/// Whether an encoder of the spec states its `accuracy`, or its gear's, whose shape no simulation can know.
bool states_accuracy(const Spec&);

/// The errors that the spec's effects and the accuracy of its encoders add, for the model of `workspace` and
/// `operational_error`.
///
/// With a motion, what an effect adds along it is a known signal; the sources are then the random effects and
/// those whose load is not known along the motion.
struct EffectReport {
  std::vector<EffectShare> shares;  ///< in the order of the spec
  std::vector<IndependentError> sources;
  std::optional<ErrorAlongMotion> along_motion = {};
};
EffectReport effect_report(const Spec&);

/// Puts the errors of the spec's effects into its model.
void add_effects(const EffectReport&, Spec&);

/// Whether effects are signals along the spec's motion; not if its record is longer than `longest_record`.
bool effects_follow_motion(const Spec&);

/// [encoder]: factor by which the effects of the spec multiply its rounding error along a motion.
Eigen::VectorXd count_factors(const Spec&);

/// All effects as sources, by their ranges, without the encoders' accuracy: for bounds that hold wherever the
/// encoder's zero is.
EffectReport effects_by_range(const Spec&);

/// One for every effect of unknown size: the missing quantity, and where to state it.
std::vector<std::string> effect_warnings(const Spec&, const std::vector<EffectShare>&);

/// Of loads that are the URDF's effort limits although it has masses; "" if there are none.
std::string warning_of_limits(const Spec&, const std::vector<EffectShare>&);

/// @throws Error (input; key `requirements`) if there are requirements on errors and an effect of unknown
/// size, as they cannot be decided then
void require_known(const Spec&, const std::vector<EffectShare>&);

/// Unit of the error that an effect adds: that of its joint, or metres if it displaces an origin.
std::string effect_unit(const Spec&, const EffectShare&);

/// A number among an effect's parameters.
struct EffectParameter {
  std::string name;
  double value = 0;
  std::string unit;
  bool usual = false;  ///< equal to the default
};

/// The numbers that are given or have defaults, in the order of the row.
std::vector<EffectParameter> effect_parameters(const Spec&, const Effect&);

/// They for people, without those that have their default: `gap 200 urad`.
std::string parameters_text(const Spec&, const Effect&);

/// `analyze` with effects that are already evaluated.
/// @param effects  of `effect_report` for this spec
Analysis analyze(const Spec&, EffectReport effects, const WorkspaceOptions&, const ProofRequest&);

/// Without warnings, which take longer than the figures of a few configurations.
/// @param effects  of `effect_report` for this spec
Analysis analysis_without_warnings(const Spec&, EffectReport effects, const WorkspaceOptions&);

/// An analysis without the bounds over the configurations and without warnings.
/// @param noise_in_motion  of the spec
Analysis unbounded_analysis(const Spec&, EffectReport effects, std::vector<Eigen::VectorXd> noise_in_motion);

/// `workspace` with sigma_quantization of every filter.
Workspace workspace_with_quantization(const OperationalModel&, const std::vector<Norms>& filters,
                                      const Configurations&, const WorkspaceOptions&);

/// What slow errors of unknown shape pass behind the filters, if they are sines of the encoder's shaft and of
/// unknown phase: one period a revolution, as of an eccentric disc or magnet, and of a gear two, as of a
/// strain wave's (Tuttle and Seering, IEEE Trans. Robotics and Automation 12(3), 1996). A scale without a
/// shaft has one period over the joint's range.
struct SlowErrorRatios {
  std::vector<SigmaRatios> accuracy, gear_accuracy;  ///< [encoder]
};

/// Along the spec's motion the mean square of the filtered sine, over the samples after the settling and over
/// the phases; without a motion the mean of |H(f)|^2 over the speeds from 0 to the URDF's limits, all equally
/// probable. NaN where neither is known, of a motion of more than `longest_record` samples, and of a loop
/// whose inertia the spec does not state.
SlowErrorRatios slow_error_ratios(const Spec&);

/// [filter]: T sum s_k^2 of the step response s, the energy of a step of 1 behind the filter [s^(1 - 2d)]; of
/// one that does not come back to 0, or not within a million samples, NaN.
std::vector<double> step_energies(const std::vector<Filter>&);

/// How slow errors behind the filters are judged, in a sentence; "" if there are none, or they are not known.
std::string slow_error_assumption(const Spec&, const std::vector<EffectShare>&);

/// Errors whose sigma in closed loops is bounded by the l1 norm, in a sentence; "" if there are none.
std::string closed_loop_assumption(const Spec&, const std::vector<EffectShare>&);

}  // namespace qerr
