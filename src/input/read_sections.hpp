#pragma once

#include <string>
#include <vector>

#include "input/object_reader.hpp"
#include "qerr/input/spec.hpp"

/// One function per section of the spec. Each stores its section in `spec` and throws Error (input) with the
/// faults of the section.
namespace qerr {

/// The dimension of a joint's coordinate: angle, or length for a prismatic joint.
inline Dimension coordinate_dimension(const IndependentJoint& joint) {
  return joint.prismatic() ? dimension::length : dimension::angle;
}

void read_encoders(const Field&, const RobotModel&, Spec&, Faults&);
/// Warns of gear ratios that contradict those of the URDF. @pre the encoders are read
void warn_of_stated_ratios(const RobotModel&, Spec&);
void read_coupling(const Field&, Spec&);
/// The pose of the tool in the tip link.
Eigen::Isometry3d read_tool(const Field&);
void read_coordinates(const Field&, Spec&);
void read_filters(const Field&, Spec&, Faults&);
/// @param field  its node is null if the section is absent; the defaults are then checked
void read_configurations(const Field&, const std::string& folder, const RobotModel&, Spec&, Faults&);
void read_requirements(const Field&, Spec&, Faults&);
void read_threshold(const Field&, Spec&);
void read_motion(const Field&, const std::string& folder, const RobotModel&, Spec&, Faults&);
void read_effects(const Field&, const RobotModel&, Spec&, Faults&);
void read_sweep(const Field&, Spec&, Faults&);

}  // namespace qerr
