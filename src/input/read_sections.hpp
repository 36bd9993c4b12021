#pragma once

#include <string>
#include <vector>

#include "input/object_reader.hpp"
#include "qerr/input/spec.hpp"

/// One function per section of the spec. Each adds to `spec` and throws Error (input) with the section's
/// faults.
namespace qerr {

/// The dimension of a joint's coordinate: angle, or length for a prismatic joint.
inline Dimension coordinate_dimension(const IndependentJoint& joint) {
  return joint.prismatic() ? dimension::length : dimension::angle;
}

std::vector<std::string> joint_names(const Chain&);

/// The index of an independent joint, by the name a section uses as key or value.
/// @throws Error saying so when the name is unknown, belongs to a fixed joint or to a mimic (with its
/// master's name)
std::size_t find_joint(const RobotModel&, const Chain&, const std::string& name, const Place&,
                       const std::string& path);

/// True when the joint exists and moves, but lies off the chain: an entry for it is not used.
bool off_chain(const RobotModel&, const Chain&, const std::string& name);

void read_encoders(const Field&, const RobotModel&, Spec&, Faults&);
void read_coupling(const Field&, Spec&);
void read_coordinates(const Field&, Spec&);
void read_filters(const Field&, Spec&, Faults&);
/// @param field  its node is null when the section is absent: the defaults are checked all the same
void read_configurations(const Field&, const std::string& folder, const RobotModel&, Spec&, Faults&);
void read_requirements(const Field&, Spec&, Faults&);
void read_threshold(const Field&, Spec&);
void read_motion(const Field&, const std::string& folder, const RobotModel&, Spec&, Faults&);
void read_effects(const Field&, const RobotModel&, Spec&, Faults&);
void read_sweep(const Field&, Spec&, Faults&);

}  // namespace qerr
