#include <filesystem>
#include <map>
#include <sstream>
#include <string_view>

#include "core/text.hpp"
#include "input/read_sections.hpp"
#include "input/urdf_reader.hpp"
#include "input/yaml_tree.hpp"
#include "qerr/core/error.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "qerr/input/first_spec.hpp"

namespace qerr {

namespace {

/// Place in a text of a line and a column, in characters, from 1.
std::size_t offset_of(const std::string& text, int line, int column) {
  std::size_t at = 0;
  for (int i = 1; i < line; ++i) at = text.find('\n', at) + 1;
  const auto continues = [&](std::size_t k) { return (static_cast<unsigned char>(text[k]) & 0xC0) == 0x80; };
  for (int i = 1; i < column; ++i) {
    ++at;
    while (at < text.size() && continues(at)) ++at;
  }
  return at;
}

constexpr int digits = 10;  ///< below 1 nm of an arm

/// Three numbers as an attribute has them, displaced.
std::string displaced(const std::string& numbers, const Eigen::Vector3d& by) {
  std::istringstream in(numbers);
  std::string out;
  for (const double d : by) {
    double present = 0;
    in >> present;
    out += (out.empty() ? "" : " ") + significant(present + d, digits);
  }
  return out;
}

void displace(std::string& text, const UrdfElement& joint, const Eigen::Vector3d& by) {
  const UrdfElement* origin = joint.child("origin");
  const UrdfAttribute* xyz = origin ? origin->attribute("xyz") : nullptr;
  const std::size_t tag =
      offset_of(text, origin ? origin->line : joint.line, origin ? origin->column : joint.column);
  const std::string moved = displaced(xyz ? xyz->value : "0 0 0", by);
  if (xyz) {
    const std::size_t name = text.find("xyz", tag), open = text.find_first_of("\"'", name);
    text.replace(open + 1, text.find(text[open], open + 1) - open - 1, moved);
  } else if (origin) {
    text.insert(text.find("origin", tag) + std::string_view("origin").size(), " xyz=\"" + moved + '"');
  } else {
    text.insert(text.find('>', tag) + 1, "<origin xyz=\"" + moved + "\"/>");
  }
}

std::string urdf_of(const Spec& spec) {
  Node root = parse_yaml(spec.text, spec.file);
  apply_changes(root, spec_changes(spec.overrides),
                [&](const Node&) -> const Chain& { return spec.model.chain; });
  const Node* robot = root.find("robot");
  const Node* urdf = robot ? robot->find("urdf") : nullptr;
  if (!urdf)
    throw Error({spec.file, 0, 0}, "--write-urdf", "the robot of the spec is not from a URDF", "",
                "leave it out: --write-model has the link dimensions as effects");
  return urdf_path(urdf->text, std::filesystem::path(spec.file).parent_path().string());
}

}  // namespace

std::string urdf_as_built(const Spec& spec, const std::vector<Effect>& found) {
  const std::string file = urdf_of(spec);
  std::string text = urdf_text(file);
  std::map<std::string, Eigen::Vector3d> moved;
  for (const std::vector<Effect>* effects : {&spec.effects, &found})
    for (const Effect& e : *effects)
      if (effect_kind(e.type).stage == Stage::kinematics) {
        const auto place = moved.try_emplace(e.joint, Eigen::Vector3d::Zero()).first;
        place->second += e.number("length") * displacement_direction(e);
      }
  for (const auto& [name, by] : moved) {
    // After each change places behind it have moved.
    const UrdfElement robot = urdf_outline(text, file);
    for (const UrdfElement& joint : robot.children)
      if (const UrdfAttribute* own = joint.attribute("name");
          joint.name == "joint" && own && own->value == name) {
        displace(text, joint, by);
        break;
      }
  }
  return text;
}

}  // namespace qerr
