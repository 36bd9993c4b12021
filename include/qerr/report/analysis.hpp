#pragma once

#include <string>
#include <vector>

#include "qerr/bound/joint_error.hpp"
#include "qerr/bound/workspace.hpp"
#include "qerr/input/spec.hpp"

namespace qerr {

/// The answer of `qerr analyze`, ready to be written in any format.
struct Analysis {
  Spec spec;
  JointError joints;
  Workspace workspace;
  std::vector<std::string> warnings;
};

/// The main job: every bound of the spec over its configurations.
Analysis analyze(const Spec&, const WorkspaceOptions& = {});

/// Unit of a coordinate behind a filter of the given derivative: "m", "rad/s", "m/s^2", ...
std::string derivative_unit(Coordinate, int derivative);

/// Each encoder's part of the tip's mean position variance (of all coordinates where no position is asked
/// for); sums to 1, or is 0 when nothing moves.
std::vector<double> encoder_budget(const Analysis&);

}  // namespace qerr
