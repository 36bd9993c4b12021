#pragma once

#include <string>
#include <vector>

#include "qerr/report/analysis.hpp"

namespace qerr {

/// How the spec's effects see the robot used: as in its motion. Without one, and for efforts that a motion of
/// a robot without masses leaves open, by the sampled range of each joint and the URDF's limits of velocity
/// and effort.
RobotUsage usage_of(const Spec&);

/// What the spec's effects add, and as which sources of error.
struct EffectReport {
  std::vector<EffectShare> shares;   ///< in the order of the spec
  std::vector<ErrorSource> sources;  ///< for the model of `workspace` and `operational_error`
};
EffectReport effect_report(const Spec&);

/// One for every effect whose size is not known: what is missing, and where it can be given.
std::vector<std::string> effect_warnings(const Spec&, const std::vector<EffectShare>&);

/// @throws Error (input; key `requirements`) when there are requirements and an effect whose size is not
/// known: what cannot be decided is no verdict
void require_known(const Spec&, const std::vector<EffectShare>&);

/// Unit of what an effect adds: that of its joint, or metres where it displaces an origin.
std::string effect_unit(const Spec&, const EffectShare&);

/// A number among an effect's parameters.
struct EffectParameter {
  std::string name;
  double value = 0;
  std::string unit;
  bool usual = false;  ///< it is the default
};

/// Those that are given or have defaults, in the order of the row.
std::vector<EffectParameter> effect_parameters(const Spec&, const Effect&);

/// The section of `analyze`: every effect, what it adds at its joint, and its parameters.
std::string effect_table(const Spec&, const std::vector<EffectShare>&);

/// `analyze` with effects that are already evaluated.
/// @param effects  of `effect_report` for this spec
Analysis analyze(const Spec&, EffectReport effects, const WorkspaceOptions&);

}  // namespace qerr
