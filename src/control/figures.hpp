#pragma once

#include <optional>
#include <string>
#include <vector>

#include "control/control.hpp"
#include "qerr/core/quantity.hpp"
#include "qerr/kinematics/chain.hpp"

namespace qerr {

/// A figure of a loop or of a wall that may be required.
struct ControlFigure {
  enum class Kind { gain_margin, phase_margin, bandwidth, limit_cycle, wall_stiffness, largest_kd };
  std::string name;  ///< `loop.a1.gain_margin`, `wall.table.stiffness`
  Kind kind = Kind::gain_margin;
  std::size_t index = 0;  ///< of the joint, or of the wall
  Dimension dimension = {};
};

/// All figures of the joints with a loop, of the walls, and of the gains.
std::vector<ControlFigure> control_figures(const Control&, const Chain&);

}  // namespace qerr
