#include <numbers>

#include "input/read_sections.hpp"
#include "input/spec_format.hpp"

namespace qerr {

Limits read_limits_of_joint(const Field& f, bool prismatic) {
  const std::string example =
      prismatic ? "[lower, upper], such as [0, 300 mm]" : "[lower, upper], such as [-90 deg, 90 deg]";
  const std::vector<Field> ends = read_list(f, example);
  if (ends.size() != 2) throw Error(f.fault("limits must be two numbers", "write " + example));
  const Parameter row{.name = "limits", .coordinate = true};
  const Dimension dimension = prismatic ? dimension::length : dimension::angle;
  const Limits limits{read_number(ends[0], row, dimension), read_number(ends[1], row, dimension)};
  if (limits.lower > limits.upper)
    throw Error(f.fault("the lower limit is above the upper one", "write " + example));
  return limits;
}

RobotModel read_joint(const Field& f, const std::string& file) {
  const Object o(f, spec_format::joint());
  const bool prismatic = o.choice("type") == "prismatic";
  Joint joint;
  joint.name = *o.text("name");
  joint.parent = "base";
  joint.child = "tip";
  joint.place = f.node->place;
  joint.velocity_limit = o.number("velocity", prismatic ? dimension::speed : dimension::angular_speed);
  joint.axis = prismatic ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitZ();
  if (o.has("limits")) joint.limits = read_limits_of_joint(o.at("limits"), prismatic);
  joint.type = prismatic ? JointType::prismatic : joint.limits ? JointType::revolute : JointType::continuous;
  // A table turns without end; its configurations are those of one turn.
  if (joint.type == JointType::continuous) joint.limits = Limits{-std::numbers::pi, std::numbers::pi};
  // The errors of a slide do not depend on its position: any range that no slide exceeds.
  constexpr double longest = 100;
  if (prismatic && !joint.limits) joint.limits = Limits{-longest, longest};
  RobotModel model{joint.name, file, {"base", "tip"}, {joint}, {}, std::vector<Inertia>(2)};
  const double radius = o.number("radius").value_or(0);
  if (radius == 0) return model;
  if (prismatic) throw Error(o.at("radius").fault("only a revolute joint has a radius", "leave it out"));
  model.joints.front().child = "hub";
  Joint arm;
  arm.name = joint.name + " arm";
  arm.parent = "hub";
  arm.child = "tip";
  arm.origin.translation().x() = radius;
  arm.place = joint.place;
  model.links = {"base", "hub", "tip"};
  model.joints.push_back(arm);
  model.inertias.resize(3);
  return model;
}

}  // namespace qerr
