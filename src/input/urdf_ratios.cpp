#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/lists.hpp"
#include "core/text.hpp"
#include "input/read_sections.hpp"
#include "input/urdf_reader.hpp"
#include "qerr/core/quantity.hpp"
#include "qerr/encoder/encoder.hpp"

// Ratios of motor to joint that a URDF states. ROS writes <transmission> with <mechanicalReduction> in its
// <actuator>, its <joint> or itself; ros2_control writes <mechanical_reduction> in the <joint> of a
// <transmission>, or <param name="mechanical_reduction"> in a <joint>; Drake <drake:gear_ratio value="..."/>
// in the <actuator>.
namespace qerr {

namespace {

bool is_ratio(const UrdfElement& element) {
  const UrdfAttribute* name = element.attribute("name");
  return element.name == "mechanicalReduction" || element.name == "mechanical_reduction" ||
         element.name == "drake:gear_ratio" ||
         (element.name == "param" && name && name->value == "mechanical_reduction");
}

const UrdfElement* ratio_in(const UrdfElement& element) {
  for (const UrdfElement& child : element.children)
    if (is_ratio(child)) return &child;
  return nullptr;
}

/// The number of a reduction; empty if it is none, or 0.
std::optional<double> number_of(const UrdfElement& ratio) {
  const UrdfAttribute* of_drake = ratio.name == "drake:gear_ratio" ? ratio.attribute("value") : nullptr;
  const auto value = parse_number(trimmed(of_drake ? of_drake->value : ratio.text));
  return value && *value != 0 ? value : std::nullopt;
}

/// Templates write 1 where they have no figure.
bool is_placeholder(double ratio) { return std::abs(ratio) == 1; }

/// An attribute, or the text of a child: ROS and ros2_control differ.
std::string word_of(const UrdfElement& element, const char* key) {
  if (const UrdfAttribute* attribute = element.attribute(key)) return attribute->value;
  const UrdfElement* child = element.child(key);
  return child ? std::string(trimmed(child->text)) : "";
}

/// `DifferentialTransmission` of `transmission_interface/DifferentialTransmission`.
std::string type_of(const UrdfElement& transmission) {
  std::string type = word_of(transmission, "type");
  if (type.empty()) type = word_of(transmission, "plugin");
  return type.substr(type.find_last_of("/:") + 1);
}

std::vector<const UrdfElement*> children_of(const UrdfElement& element, const char* tag) {
  std::vector<const UrdfElement*> found;
  for (const UrdfElement& child : element.children)
    if (child.name == tag) found.push_back(&child);
  const auto has_role = [&](std::size_t i, char number) {
    return word_of(*found[i], "role") == std::string(tag) + number;
  };
  // Roles, joint1 and joint2, beat the order in the file.
  if (found.size() == 2 && has_role(0, '2') && has_role(1, '1')) std::swap(found[0], found[1]);
  return found;
}

/// Joint motion = matrix * (motor angle / ratio of the motor), of ros_control's transmissions of two joints
/// with the reductions j1, j2 (transmission_interface, differential_transmission.h and
/// four_bar_linkage_transmission.h).
std::optional<Eigen::Matrix2d> coupling_of(const std::string& type, double j1, double j2) {
  Eigen::Matrix2d c;
  if (type == "DifferentialTransmission")
    c << 1 / (2 * j1), 1 / (2 * j1), 1 / (2 * j2), -1 / (2 * j2);
  else if (type == "FourBarLinkageTransmission")
    c << 1 / j1, 0, -1 / (j1 * j2), 1 / j2;
  else
    return std::nullopt;
  return c;
}

constexpr double ratio_rounding = 1e-3;         // data sheets round: 36.17 is 36.167452
constexpr std::size_t most_contradictions = 6;  // joints in the warning

/// `'lift' -52143.3 (spec: 628.3 rad/m)`; "" where the two agree, or one of them is not stated.
std::string contradiction(const Joint& in_urdf, const Encoder& encoder, const EncoderFigures& figures,
                          bool prismatic) {
  // 1 is the placeholder of every template of a <transmission>.
  if (!in_urdf.stated_ratio || std::abs(*in_urdf.stated_ratio) == 1) return "";
  if (!encoder_kind(figures.kind).counts_per_rev) return "";
  const double stated = *in_urdf.stated_ratio, used = encoder.shaft_ratio;
  const bool of_gear = prismatic && !stated_travel(in_urdf);
  if (std::abs((of_gear ? figures.gear_ratio : used) - stated) <= ratio_rounding * std::abs(stated))
    return "";
  return "'" + in_urdf.name + "' " + shortest(stated) + " (spec: " +
         (prismatic && !of_gear ? shortest(used) + " rad of the encoder per metre"
                                : "gear_ratio " + shortest(used)) +
         ")";
}

/// The rows and columns of two joints of the spec's coupling.
Eigen::Matrix2d block_of(const Coupling& coupling, const std::array<Eigen::Index, 2>& at) {
  Eigen::Matrix2d block;
  block << coupling(at[0], at[0]), coupling(at[0], at[1]), coupling(at[1], at[0]), coupling(at[1], at[1]);
  return block;
}

/// Whether one column is the other, up to the rounding of data sheets. @param scaled  up to a factor, too
bool same_column(const Eigen::Vector2d& used, const Eigen::Vector2d& stated, bool scaled) {
  const double factor = scaled ? stated.dot(used) / used.squaredNorm() : 1;
  return (factor * used - stated).norm() <= ratio_rounding * stated.norm();
}

/// What the spec has instead of a coupling that the URDF states; "" where the two agree, in either order of
/// the motors.
std::string contradiction(const StatedCoupling& stated, const Spec& spec,
                          const std::array<Eigen::Index, 2>& at) {
  const Eigen::Matrix2d block = block_of(spec.model.transmission.coupling, at);
  Eigen::Matrix2d used = block;  // joint motion per motor angle
  std::array<double, 2> ratios{};
  for (std::size_t k = 0; k < 2; ++k) {
    const auto i = static_cast<std::size_t>(at[k]);
    if (!encoder_kind(spec.encoder_figures[i].kind).counts_per_rev) return "";
    ratios[k] = spec.encoder_figures[i].gear_ratio;
    used.col(k) /= spec.model.transmission.encoders[i].shaft_ratio;
  }
  const auto same = [&](Eigen::Index column, std::size_t motor) {
    const double ratio = stated.ratios[motor];
    return same_column(used.col(column), stated.coupling.col(motor) / ratio, std::abs(ratio) == 1);
  };
  if ((same(0, 0) && same(1, 1)) || (same(0, 1) && same(1, 0))) return "";
  return quoted(stated.joints[0]) + " and " + quoted(stated.joints[1]) + " by the " + stated.type + ' ' +
         quoted(stated.transmission) + ": " + coupling_text(stated.ratios, stated.coupling) +
         " (spec: " + coupling_text(ratios, block) + ')';
}

/// Warns of couplings that the spec contradicts or cannot have. The joints of all of them.
std::vector<std::string> warn_of_couplings(const RobotModel& robot, Spec& spec) {
  std::vector<std::string> coupled;
  for (const StatedCoupling& stated : robot.couplings) {
    std::array<Eigen::Index, 2> at{-1, -1};
    for (std::size_t i = 0; i < 2; ++i)
      for (std::size_t j = 0; j < spec.model.chain.independent.size(); ++j)
        if (spec.model.chain.independent[j].name == stated.joints[i]) at[i] = static_cast<Eigen::Index>(j);
    coupled.insert(coupled.end(), stated.joints.begin(), stated.joints.end());
    if (at[0] < 0 && at[1] < 0) continue;
    if (at[0] < 0 || at[1] < 0) {
      const std::size_t in = at[0] < 0 ? 1 : 0;
      spec.warnings.push_back("the URDF couples " + quoted(stated.joints[in]) + " with " +
                              quoted(stated.joints[1 - in]) + ", which is not between base and tip, by the " +
                              stated.type + ' ' + quoted(stated.transmission) +
                              ": the share of a second motor in its error is not counted");
    } else if (const std::string found = contradiction(stated, spec, at); !found.empty()) {
      spec.warnings.push_back("the URDF couples joints otherwise than the spec: " + found +
                              "; the spec's is used: check which is right, and where the encoders are");
    }
  }
  return coupled;
}

}  // namespace

std::string coupling_text(const std::array<double, 2>& ratios, const Eigen::Matrix2d& c) {
  const auto row = [&](Eigen::Index i) {
    return '[' + significant(c(i, 0), 5) + ", " + significant(c(i, 1), 5) + ']';
  };
  return "gear_ratio " + shortest(ratios[0]) + " and " + shortest(ratios[1]) + ", coupling [" + row(0) +
         ", " + row(1) + ']';
}

std::optional<double> stated_travel(const Joint& joint) {
  if (joint.type != JointType::prismatic || !joint.stated_ratio) return std::nullopt;
  constexpr double largest = 0.5;  // [m], of a pulley of 160 mm on the motor's shaft
  const double travel = 2 * std::numbers::pi / std::abs(*joint.stated_ratio);
  const double range = joint.limits ? joint.limits->upper - joint.limits->lower : 0;
  return travel <= (range > 0 ? std::min(range, largest) : largest) ? std::optional(travel) : std::nullopt;
}

void UrdfReader::read_ratios(const UrdfElement& root) {
  Reductions stated;
  for (const UrdfElement& child : root.children) {
    if (child.name == "transmission") read_transmission(child, false, stated);
    if (child.name == "gazebo") warn_of_transmissions_inside(child);
    if (child.name != "ros2_control") continue;
    for (const UrdfElement& inner : child.children) {
      if (inner.name == "transmission") read_transmission(inner, true, stated);
      const UrdfAttribute* name = inner.attribute("name");
      if (inner.name == "joint" && name && ratio_in(inner)) stated[name->value].push_back(ratio_in(inner));
    }
  }
  for (WrittenJoint& w : written)
    if (const auto found = stated.find(w.joint.name); found != stated.end())
      settle_ratio(w.joint, found->second);
  warn_of_unused_ratios(stated);
  flaws_.concern_document();
}

/// Joints whose own encoder no figure has: that follow another, or that two motors move together.
void UrdfReader::warn_of_unused_ratios(const Reductions& stated) {
  for (const WrittenJoint& w : written) {
    const auto found = stated.find(w.joint.name);
    if (found == stated.end() || is_placeholder(w.joint.stated_ratio.value_or(1))) continue;
    const auto coupling = std::ranges::find_if(
        model.couplings, [&](const StatedCoupling& c) { return contains(c.joints, w.joint.name); });
    if (!w.joint.mimic && coupling == model.couplings.end()) continue;
    flaws_.concern_joint(w.joint.name);
    flaws_.warn(*found->second.front(), "joint " + qerr::quoted(w.joint.name),
                "the mechanical reduction is not used: the joint " +
                    (w.joint.mimic ? "follows " + qerr::quoted(w.joint.mimic->joint)
                                   : "is moved by " + qerr::quoted(coupling->transmission) + ", too"),
                shortest(*w.joint.stated_ratio),
                w.joint.mimic ? "state the gear_ratio of " + qerr::quoted(w.joint.mimic->joint) +
                                    " if its encoder is there"
                              : "state gear_ratio and coupling in the spec");
  }
}

/// Neither ROS nor a simulator reads a transmission there.
void UrdfReader::warn_of_transmissions_inside(const UrdfElement& gazebo) {
  for (const UrdfElement& child : gazebo.children) {
    if (child.name != "transmission") continue;
    flaws_.concern_document();
    flaws_.warn(child, child.title(), "a transmission inside of <gazebo> is not read", "",
                "write it in <robot> itself, or state gear_ratio in the spec");
  }
}

void UrdfReader::read_transmission(const UrdfElement& element, bool ros2, Reductions& stated) {
  const auto joints = children_of(element, "joint"), actuators = children_of(element, "actuator");
  const std::string type = type_of(element);
  std::vector<std::string> moved;
  for (const UrdfElement& child : element.children) {
    const std::string name = word_of(child, "name");
    const auto at = joint_index_.find(name);
    if (at != joint_index_.end() && written[at->second].joint.type != JointType::fixed &&
        !contains(moved, name))
      moved.push_back(name);
  }
  if (moved.empty()) {
    warn_of_foreign_joint(element, joints);
    return;
  }
  flaws_.concern_joints(moved);
  if (joints.size() == 1 && actuators.size() <= 1) {
    // ROS takes the reduction of the actuator, ros2_control that of the joint.
    std::vector<const UrdfElement*> owners{&element, joints[0]};
    if (!actuators.empty()) owners.insert(owners.begin(), actuators[0]);
    if (ros2) std::ranges::reverse(owners);
    const std::string name = word_of(*joints[0], "name");
    const UrdfElement* ratio = only_reduction(owners, name);
    if (ratio) stated[name].push_back(ratio);
    if (const std::string motor = actuators.empty() ? "" : word_of(*actuators[0], "name"); !motor.empty()) {
      const auto [known, fresh] = motors_.try_emplace(motor, name);
      if (!fresh && known->second != name) {
        flaws_.concern_joints(std::vector<std::string>{known->second, name});
        flaws_.warn(element, element.title(),
                    "actuator " + qerr::quoted(motor) + " moves " + qerr::quoted(known->second) +
                        ", too: that they share it "
                        "is not read",
                    "", "state gear_ratio and coupling of these joints in the spec");
      }
    }
    for (const UrdfElement* owner : owners)
      if (!ratio && owner->attribute("mechanicalReduction"))
        flaws_.warn(*owner, "joint " + qerr::quoted(name), "ROS reads mechanicalReduction as an element only",
                    "an attribute", "write <mechanicalReduction>...</mechanicalReduction> in it");
    if (ratio && !type.empty() && !type.ends_with("SimpleTransmission"))
      flaws_.warn(element, element.title(),
                  "the equations of this " + type + " of " + qerr::quoted(name) + " are not known", "",
                  "its reduction is taken for the ratio of motor to joint: state gear_ratio in the spec");
    return;
  }
  const std::string obstacle = read_coupling(type, element);
  if (obstacle.empty()) return;
  flaws_.warn(element, element.title(),
              (type.empty() ? "a transmission" : "this " + type) + " of " +
                  joined(moved, ", ", qerr::quoted) + " is not read: " + obstacle,
              "", "state gear_ratio (and coupling) of these joints in the spec");
}

/// A transmission of a joint that the robot does not have: misspelt, or left over from another robot.
void UrdfReader::warn_of_foreign_joint(const UrdfElement& transmission,
                                       const std::vector<const UrdfElement*>& joints) {
  const bool has_ratio = std::ranges::any_of(transmission.children, [](const UrdfElement& child) {
    const UrdfElement* ratio = ratio_in(child);
    return ratio && !is_placeholder(number_of(*ratio).value_or(0));
  });
  if (!has_ratio || joints.empty() || joint_index_.contains(word_of(*joints[0], "name"))) return;
  flaws_.concern_document();
  flaws_.warn(
      transmission, transmission.title(),
      "the robot has no joint " + qerr::quoted(word_of(*joints[0], "name")) + ": its reduction is not used",
      "", "correct the name of the joint, or state gear_ratio in the spec");
}

/// The reduction of the first owner that has a figure. Several figures are told.
const UrdfElement* UrdfReader::only_reduction(const std::vector<const UrdfElement*>& owners,
                                              const std::string& joint) {
  const UrdfElement *chosen = nullptr, *owner = nullptr;
  for (const UrdfElement* candidate : owners) {
    const UrdfElement* ratio = ratio_in(*candidate);
    if (!ratio) continue;
    const double value = number_of(*ratio).value_or(0);
    const double before = chosen ? number_of(*chosen).value_or(0) : 1;
    if (!chosen || is_placeholder(before)) {
      chosen = ratio;
      owner = candidate;
    } else if (!is_placeholder(value) && value != before) {
      flaws_.warn(*ratio, "joint " + qerr::quoted(joint), "the transmission states two mechanical reductions",
                  qerr::quoted(std::string(trimmed(chosen->text))) + " and " +
                      qerr::quoted(std::string(trimmed(ratio->text))),
                  "that of the <" + owner->name + "> is used, as ROS uses it");
    }
  }
  return chosen;
}

/// Why the transmission cannot be read as two coupled joints; "" if it was.
std::string UrdfReader::read_coupling(const std::string& type, const UrdfElement& transmission) {
  const auto joints = children_of(transmission, "joint"), actuators = children_of(transmission, "actuator");
  if (!coupling_of(type, 1, 1)) return "its equations are not known";
  if (joints.size() != 2 || actuators.size() != 2) return "it does not have two joints and two actuators";
  StatedCoupling stated{word_of(transmission, "name"), type, {}, {}, {}};
  std::array<double, 2> reductions{1, 1};
  for (std::size_t i = 0; i < 2; ++i) {
    stated.joints[i] = word_of(*joints[i], "name");
    const UrdfElement *of_joint = ratio_in(*joints[i]), *of_motor = ratio_in(*actuators[i]);
    const auto joint = of_joint ? number_of(*of_joint) : 1, motor = of_motor ? number_of(*of_motor) : 1;
    if (!joint || !motor) return "a mechanical reduction must be a number other than 0";
    reductions[i] = *joint;
    stated.ratios[i] = *motor;
  }
  stated.coupling = *coupling_of(type, reductions[0], reductions[1]);
  const std::string obstacle = obstacle_to_coupling(stated);
  if (!obstacle.empty()) return obstacle;
  const auto have_roles = [](const std::vector<const UrdfElement*>& parts) {
    return word_of(*parts[0], "role").ends_with('1') && word_of(*parts[1], "role").ends_with('2');
  };
  if (!have_roles(joints) || !have_roles(actuators))
    flaws_.warn(transmission, transmission.title(),
                "no roles say which joint and which actuator is the first: taken in their order", "",
                "ROS requires joint1, joint2, actuator1 and actuator2");
  model.couplings.push_back(std::move(stated));
  return "";
}

std::string UrdfReader::obstacle_to_coupling(const StatedCoupling& stated) const {
  if (!stated.coupling.allFinite()) return "its reductions are out of range";
  if (stated.joints[0] == stated.joints[1]) return "its joints are one";
  for (const std::string& name : stated.joints) {
    const auto found = joint_index_.find(name);
    if (found == joint_index_.end()) return "the robot has no joint " + qerr::quoted(name);
    const Joint& joint = written[found->second].joint;
    if (joint.mimic || !has_one_coordinate(joint.type))
      return qerr::quoted(name) + " is a " +
             (joint.mimic ? "mimic" : std::string(joint_type_name(joint.type))) + " joint";
    for (const StatedCoupling& other : model.couplings)
      if (contains(other.joints, name))
        return qerr::quoted(name) + " is in " + qerr::quoted(other.transmission) + ", too";
  }
  return "";
}

/// The ratio on which all that the URDF states agree.
void UrdfReader::settle_ratio(Joint& joint, const std::vector<const UrdfElement*>& stated) {
  flaws_.concern_joint(joint.name);
  const std::string key = "joint " + qerr::quoted(joint.name);
  std::optional<double> placeholder, ratio;
  for (const UrdfElement* element : stated) {
    const auto value = number_of(*element);
    if (!value) {
      flaws_.warn(*element, key, "the mechanical reduction must be a number other than 0",
                  qerr::quoted(std::string(trimmed(element->text))), "it is ignored");
    } else if (is_placeholder(*value)) {
      placeholder = value;
    } else if (ratio.value_or(*value) != *value) {
      flaws_.warn(*element, key, "the joint has two mechanical reductions",
                  shortest(std::min(*ratio, *value)) + " and " + shortest(std::max(*ratio, *value)),
                  "none is used: state gear_ratio in the spec");
      return;
    } else {
      ratio = value;
    }
  }
  joint.stated_ratio = ratio ? ratio : placeholder;
  if (ratio && joint.type == JointType::prismatic && !stated_travel(joint))
    flaws_.warn(
        *stated.front(), key,
        "the mechanical reduction of a prismatic joint is in motor radians per metre, and this one is too "
        "small for a screw or pulley on the motor",
        shortest(*ratio) + ", which is " + significant(2 * std::numbers::pi / std::abs(*ratio), 3) +
            " m a revolution",
        "taken for the ratio of a gear before screw or pulley: state travel_per_rev in the spec");
}

void warn_of_stated_ratios(const RobotModel& robot, Spec& spec) {
  const std::vector<std::string> coupled = warn_of_couplings(robot, spec);
  std::string text;
  std::size_t count = 0;
  for (std::size_t i = 0; i < spec.model.chain.independent.size(); ++i) {
    const IndependentJoint& joint = spec.model.chain.independent[i];
    if (contains(coupled, joint.name)) continue;
    const std::string found =
        contradiction(*find_named(robot.joints, joint.name), spec.model.transmission.encoders[i],
                      spec.encoder_figures[i], joint.prismatic());
    if (found.empty()) continue;
    if (++count <= most_contradictions) text += (text.empty() ? "" : ", ") + found;
  }
  if (count > most_contradictions) text += " and " + std::to_string(count - most_contradictions) + " more";
  if (count > 0)
    spec.warnings.push_back("the URDF states other ratios (mechanical reduction) than the spec: " + text +
                            "; the spec's are used: check which is right, and on which side of the gear the "
                            "encoder is");
}

}  // namespace qerr
