#include <filesystem>

#include "qerr/core/suggest.hpp"
#include "qerr/input/spec_format.hpp"
#include "read_sections.hpp"

/// How the robot moves and what it does to the ideal model: motion, effects.
namespace qerr {

namespace {

JointMotion read_joint_motion(const Field& f, const IndependentJoint& joint) {
  const Object o(f, spec_format::joint_motion());
  const Dimension unit = coordinate_dimension(joint);
  Dimension per_second = unit;
  per_second.second = -1;
  JointMotion motion;
  motion.center = *o.number("center", unit);
  motion.velocity = *o.number("velocity", per_second);
  if (!o.has("sines")) return motion;
  for (const Field& item : read_list(o.at("sines"))) {
    const Object sine(item, spec_format::sine());
    motion.sines.push_back(
        {*sine.number("amplitude", unit), *sine.number("frequency"), *sine.number("phase")});
  }
  return motion;
}

const EffectKind& effect_kind(const Field& f) {
  std::vector<std::string> known;
  for (const EffectKind& kind : effect_kinds()) known.emplace_back(kind.name);
  if (f.node->type != Node::Type::mapping)
    throw Error(f.fault("must be a mapping", "write {type: ..., joint: ...}"));
  const Node* type = f.node->find("type");
  if (!type)
    throw Error(
        {f.node->place, f.path + ".type", "missing key", "", "add 'type: ...'; see `qerr list effects`"});
  const Field field{type, f.path + ".type"};
  const std::string name = read_text_value(field);
  for (const EffectKind& kind : effect_kinds())
    if (kind.name == name) return kind;
  throw Error(field.fault("no such effect", did_you_mean(name, known)));
}

Effect read_effect(const Field& f, const RobotModel& robot, const Spec& spec) {
  const EffectKind& kind = effect_kind(f);
  std::vector<Parameter> format = spec_format::effect();
  format.insert(format.end(), kind.parameters.begin(), kind.parameters.end());
  const Object o(f, format);
  Effect effect{std::string(kind.name), {}, {}, {}};
  const auto joint = o.text("joint");
  if (!joint)
    throw Error(
        {f.node->place, f.path + ".joint", "missing key", "", "add 'joint: NAME', the joint it acts on"});
  const std::size_t index =
      find_joint(robot, spec.model.chain, *joint, o.at("joint").node->place, o.at("joint").path);
  effect.joint = *joint;
  const Dimension unit = coordinate_dimension(spec.model.chain.independent[index]);
  effect.numbers = o.numbers(kind.parameters, unit);
  effect.choices = o.choices(kind.parameters);
  return effect;
}

}  // namespace

void read_motion(const Field& f, const std::string& folder, const RobotModel& robot, Spec& spec,
                 Faults& faults) {
  const Object o(f, spec_format::motion());
  Motion motion;
  motion.sample_rate = o.number("sample_rate").value_or(0);
  motion.duration = o.number("duration").value_or(0);
  if (o.has("file") == o.has("joints"))
    throw Error(f.fault(o.has("file") ? "the motion is given by a file or by joints, not by both"
                                      : "the motion says nothing of the joints",
                        "give one of joints and file"));
  if (const auto file = o.text("file")) {
    motion.file = (std::filesystem::path(folder) / *file).string();
    spec.motion = motion;
    return;
  }
  for (const std::string key : {"sample_rate", "duration"})
    if (!o.has(key))
      throw Error({f.node->place, f.path + '.' + key, "missing key", "", "add '" + key + ": ...'"});
  motion.joints.resize(spec.model.chain.independent.size());
  for (const auto& entry : read_map(o.at("joints"))) {
    if (off_chain(robot, spec.model.chain, entry.first.name)) {
      spec.warnings.push_back(entry.second.path + " is not used: the joint is not between base and tip");
      continue;
    }
    faults.guard([&] {
      const std::size_t i =
          find_joint(robot, spec.model.chain, entry.first.name, entry.first.place, entry.second.path);
      motion.joints[i] = read_joint_motion(entry.second, spec.model.chain.independent[i]);
    });
  }
  spec.motion = motion;
}

void read_effects(const Field& f, const RobotModel& robot, Spec& spec, Faults& faults) {
  for (const Field& item : read_list(f))
    faults.guard([&] { spec.effects.push_back(read_effect(item, robot, spec)); });
}

}  // namespace qerr
