#include <cmath>
#include <map>

#include "core/text.hpp"
#include "input/urdf_reader.hpp"
#include "qerr/core/quantity.hpp"

// Ratios of motor to joint that a URDF states. ROS writes <transmission> with <mechanicalReduction> in its
// <actuator>, its <joint> or itself; ros2_control writes <mechanical_reduction> in the <joint> of a
// <transmission>, or <param name="mechanical_reduction"> in a <joint>.
namespace qerr {

namespace {

bool is_ratio(const UrdfElement& element) {
  const UrdfAttribute* name = element.attribute("name");
  return element.name == "mechanicalReduction" || element.name == "mechanical_reduction" ||
         (element.name == "param" && name && name->value == "mechanical_reduction");
}

const UrdfElement* ratio_in(const UrdfElement& element) {
  for (const UrdfElement& child : element.children)
    if (is_ratio(child)) return &child;
  return nullptr;
}

std::string trimmed(const std::string& text) {
  constexpr const char* blank = " \t\r\n";
  const std::size_t begin = text.find_first_not_of(blank);
  return begin == std::string::npos ? "" : text.substr(begin, text.find_last_not_of(blank) - begin + 1);
}

struct StatedRatio {
  std::string joint;
  const UrdfElement* ratio = nullptr;
};

/// The ratio of a transmission of one joint; one of several joints is a differential, which no single ratio
/// describes.
void add_transmission(const UrdfElement& transmission, std::vector<StatedRatio>& stated) {
  const UrdfElement *joint = nullptr, *ratio = ratio_in(transmission);
  for (const UrdfElement& child : transmission.children) {
    if (child.name == "joint" && joint) return;
    if (child.name == "joint") joint = &child;
    const UrdfElement* inner = child.name == "joint" || child.name == "actuator" ? ratio_in(child) : nullptr;
    // Templates write 1 where they have no figure.
    if (inner && (!ratio || trimmed(ratio->text) == "1")) ratio = inner;
  }
  const UrdfAttribute* name = joint ? joint->attribute("name") : nullptr;
  if (name && ratio) stated.push_back({name->value, ratio});
}

std::vector<StatedRatio> all_stated(const UrdfElement& root) {
  std::vector<StatedRatio> stated;
  for (const UrdfElement& child : root.children) {
    if (child.name == "transmission") add_transmission(child, stated);
    if (child.name != "ros2_control") continue;
    for (const UrdfElement& inner : child.children) {
      if (inner.name == "transmission") add_transmission(inner, stated);
      const UrdfAttribute* name = inner.attribute("name");
      if (inner.name == "joint" && name && ratio_in(inner)) stated.push_back({name->value, ratio_in(inner)});
    }
  }
  return stated;
}

}  // namespace

void UrdfReader::read_ratios(const UrdfElement& root) {
  for (const StatedRatio& s : all_stated(root)) {
    const auto found = joint_index_.find(s.joint);
    if (found == joint_index_.end()) continue;
    flaws_.concern_joint(s.joint);
    Joint& joint = written[found->second].joint;
    const std::string text = trimmed(s.ratio->text), key = "joint " + quoted(s.joint);
    const auto value = parse_number(text);
    if (!value || *value == 0)
      flaws_.warn(*s.ratio, key, "the mechanical reduction must be a number other than 0", quoted(text),
                  "it is ignored");
    else if (joint.stated_ratio && *joint.stated_ratio != *value)
      flaws_.warn(*s.ratio, key, "the joint has two mechanical reductions",
                  shortest(*joint.stated_ratio) + " and " + shortest(*value), "the first one is used");
    else
      joint.stated_ratio = value;
  }
  flaws_.concern_document();
}

}  // namespace qerr
