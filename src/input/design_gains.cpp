#include <algorithm>

#include "control/control.hpp"
#include "input/design_sections.hpp"
#include "input/joint_entries.hpp"
#include "input/spec_format.hpp"

namespace qerr {

namespace {

/// The values of one gain, which all joints of the entry take together.
void read_gain_options(const Object& o, const char* key, const GainOptions& of, const Spec& spec,
                       DesignRequest& request) {
  if (!o.has(key)) return;
  GainOptions options = of;
  options.key = key;
  const Field f = o.at(key);
  for (const std::size_t j : of.joints) {
    const JointController& stated = spec.model.control->joints[j];
    if (!((options.key == "kp" ? stated.kp : stated.kd) > 0))
      throw Error(
          f.fault("the controller of joint " + quoted(spec.model.chain.independent[j].name) + " has none",
                  "state one in control.joints, which is then replaced"));
  }
  const bool prismatic = spec.model.chain.independent[of.joints.front()].prismatic();
  Dimension d = prismatic ? Dimension{-1, 0, 0, 1} : Dimension{1, -1, 0, 1};
  if (options.key == "kd") d.second = 1;
  for (const Node& value : values_of(f))
    options.values.push_back(
        read_number({&value, f.path}, {.name = key, .dimension = d, .least = 0, .open_below = true}));
  // The largest gain first: of designs that are equal otherwise, the stiffest.
  std::sort(options.values.rbegin(), options.values.rend());
  request.gains.push_back(std::move(options));
}

}  // namespace

void read_design_gains(const Field& f, const RobotModel& robot, const Spec& spec, DesignRequest& request,
                       Faults& faults) {
  if (!spec.model.control)
    throw Error(f.fault("gains are those of `control:`", "add control: {joints: {'*': {kp: ..., kd: ...}}}"));
  for (const auto& entry : read_map(f))
    faults.guard([&] {
      const auto& [key, field] = entry;
      const Object o(field, spec_format::design_gains());
      if (!o.has("kp") && !o.has("kd"))
        throw Error(field.fault("has nothing to choose", "give lists of kp or kd"));
      GainOptions of;
      of.place = key.place;
      of.joints = find_joints(robot, spec.model.chain, key.name, key.place, field.path);
      for (const GainOptions& other : request.gains)
        for (const std::size_t j : of.joints)
          if (std::find(other.joints.begin(), other.joints.end(), j) != other.joints.end())
            throw Error({key.place, field.path, "the gains of a joint are in two entries",
                         quoted(spec.model.chain.independent[j].name), "keep one"});
      for (const char* const gain : {"kp", "kd"}) read_gain_options(o, gain, of, spec, request);
    });
}

}  // namespace qerr
