#pragma once

#include <string>
#include <vector>

#include "bound/control_bounds.hpp"
#include "qerr/report/analysis.hpp"
#include "qerr/report/write.hpp"
#include "report/analysis/figure_names.hpp"
#include "report/text_table.hpp"

/// The section of `analyze` about loops and walls, and its figures in requirements.
namespace qerr {

/// The largest kd with which a joint's torque meets its requirements, the loop open and kp as stated.
struct GainReport {
  std::size_t joint = 0;
  double kd = 0;         ///< [N m s/rad or N s/m]
  std::string quantity;  ///< the requirement that limits it
};

/// Loops of all joints whose inertia is known, and all walls for which everything is stated.
struct ControlReport {
  std::vector<OpenTorque> torques;  ///< of joints with a controller
  std::vector<WorstLoop> loops;
  std::vector<WorstWall> walls;
  std::vector<GainReport> gains;  ///< of joints with a requirement on their torque
};

/// Loops and walls are evaluated at this many configurations at most, the first of the spec.
inline constexpr std::uint64_t configurations_of_control = 10'000;

/// Over the configurations of the spec, of more than 10000 the first.
/// @param required_only  without torques, and loops of joints that no requirement of the spec names
ControlReport control_report(const Spec&, bool required_only = false);

/// Refuses requirements on loops and walls beside effects that change them in a way that is not counted.
/// @throws Error (input; key `requirements`)
void refuse_changed_loops(const Spec&);

/// The value of a requirement on a figure of a loop or a wall: infinite if unbounded, NaN for an unstable
/// loop, which meets no limit.
/// @throws Error (input) if it needs what is not stated
double control_value(const Requirement&, const Spec&, const ControlReport&);

/// The least margin, bandwidth, stiffness and gain over the configurations, the largest cycle.
std::vector<SingleFigure> control_rows(const Spec&, const ControlReport&);

/// Whether a requirement is on such a figure.
bool any_of_control(const Spec&);

/// One for each unstable loop and each wall that lacks a statement.
std::vector<std::string> control_warnings(const Spec&, const ControlReport&);

/// A table of torques, loops or walls for people, its header first, with remarks below it.
struct ControlTable {
  std::string title;
  TableRows rows;
  std::vector<std::string> notes;
};
std::vector<ControlTable> control_tables(const Spec&, const ControlReport&);

/// They as sections of a terminal's table.
std::string control_text(const Spec&, const ControlReport&, const Style&);

}  // namespace qerr
