#pragma once

#include <string>
#include <vector>

#include "qerr/bound/joint_error.hpp"
#include "qerr/bound/workspace.hpp"
#include "qerr/input/spec.hpp"
#include "qerr/report/effect_report.hpp"

namespace qerr {

/// The answer of `qerr analyze`, ready to be written in any format.
struct Analysis {
  Spec spec;
  JointError joints;
  Workspace workspace;
  std::vector<Eigen::VectorXd> noise_in_motion;  ///< [filter][encoder], in quantization intervals
  std::vector<std::string> warnings;
  std::vector<EffectShare> effects = {};  ///< of the spec, in its order
};

/// The main job: every bound of the spec over its configurations, with its effects.
Analysis analyze(const Spec&, const WorkspaceOptions& = {});

/// The same where the effects have been looked at already.
/// @param effects  of `effect_report` for this spec
Analysis analyze(const Spec&, EffectReport effects, const WorkspaceOptions& = {});

/// For every filter the noise of each encoder along the spec's motion (noise_along_motion.hpp), for
/// WorkspaceOptions; empty without a motion, and for a filter whose memory is too long to be followed.
std::vector<Eigen::VectorXd> noise_in_motion(const Spec&);

/// Unit of a coordinate behind a filter of the given derivative: "m", "rad/s", "m/s^2", ...
std::string derivative_unit(Coordinate, int derivative);

/// Each encoder's part of the tip's mean position variance (of all coordinates where no position is asked
/// for); sums to 1, or is 0 when nothing moves.
std::vector<double> encoder_budget(const Analysis&);

}  // namespace qerr
