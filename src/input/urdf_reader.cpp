#include "input/urdf_reader.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/physical_range.hpp"
#include "core/suggest.hpp"
#include "core/text.hpp"
#include "input/urdf_flaws.hpp"
#include "qerr/core/quantity.hpp"

namespace qerr {

namespace {

using Names = std::vector<std::string>;

std::vector<std::string_view> split(std::string_view text) {
  std::vector<std::string_view> words;
  constexpr std::string_view blank = " \t\r\n";
  for (std::size_t at = text.find_first_not_of(blank); at != std::string_view::npos;) {
    const std::size_t end = std::min(text.find_first_of(blank, at), text.size());
    words.push_back(text.substr(at, end - at));
    at = text.find_first_not_of(blank, end);
  }
  return words;
}

}  // namespace

void UrdfReader::read(const UrdfElement& root) {
  check_vocabulary(root, file_, flaws_);
  read_robot(root);
  for (const UrdfElement& child : root.children) {
    flaws_.concern(child);
    if (child.name == "link") read_link(child);
    if (child.name == "joint") read_joint(child);
  }
  if (model.links.empty()) {
    flaws_.raise();
    refuse(root, "a robot must have at least one link", "",
           root.attribute("xmlns:xacro") ? "is this a file of xacro macros? Expand the file that calls them"
                                         : "");
  }
  check_tree(root);
  check_mimics();
  read_ratios(root);
  model.flaws = flaws_.take();
}

void UrdfReader::refuse(const UrdfElement& root, std::string rule, std::string found, std::string remedy) {
  throw Error(Fault{
      {file_, root.line, root.column}, root.title(), std::move(rule), std::move(found), std::move(remedy)});
}

/// Exactly N numbers of an attribute; empty if it is absent or, after reporting a fault, invalid.
template <std::size_t N>
std::optional<std::array<double, N>> UrdfReader::numbers(const UrdfElement& element, const char* name,
                                                         const std::string& key) {
  const UrdfAttribute* attribute = element.attribute(name);
  if (!attribute) return {};
  const auto words = split(attribute->value);
  // An axis is a direction, of any length.
  const bool is_length = element.name == "origin" && name == std::string_view("xyz");
  const double most = element.name == "axis"
                          ? HUGE_VAL
                          : physical_range(is_length ? dimension::length : dimension::none).largest;
  bool too_large = false;
  std::array<double, N> values{};
  bool good = words.size() == N;
  for (std::size_t i = 0; good && i < N; ++i) {
    const auto value = parse_number(words[i]);
    good = value.has_value();
    too_large = too_large || std::abs(value.value_or(0)) > most;
    values[i] = value.value_or(0);
  }
  if (good && !too_large) return values;
  if (good) {
    spoil(*attribute, key, "'" + std::string(name) + "' of <" + element.name + "> is out of range",
          quoted(attribute->value), "give values of at most " + shortest(most));
    return {};
  }
  const bool comma = attribute->value.find(',') != std::string::npos;
  spoil(*attribute, key,
        "'" + std::string(name) + "' of <" + element.name + "> must be " +
            (N == 1 ? "a finite number" : counted(N, "finite number")),
        quoted(attribute->value), comma ? "use a decimal point, and blanks between numbers" : "");
  return {};
}

std::optional<double> UrdfReader::number(const UrdfElement& element, const char* name,
                                         const std::string& key) {
  const auto one = numbers<1>(element, name, key);
  return one ? std::optional((*one)[0]) : std::nullopt;
}

template std::optional<std::array<double, 3>> UrdfReader::numbers<3>(const UrdfElement&, const char*,
                                                                     const std::string&);

/// The name of a link or joint; "" after reporting a flaw.
std::string UrdfReader::name_of(const UrdfElement& element) {
  const UrdfAttribute* name = element.attribute("name");
  if (!name)
    spoil(element, element.name, "a " + element.name + " must have a name", "", "");
  else if (name->value.empty())
    spoil(*name, element.name, "the name of a " + element.name + " must not be empty", "", "");
  else if (escaped(name->value, std::string::npos) != name->value)
    spoil(*name, element.name, "a name must not contain control or invisible characters", quoted(name->value),
          "type it anew");
  return name ? name->value : "";
}

/// A required attribute of a required child; "" after reporting a fault.
std::string UrdfReader::text_of(const UrdfElement* element, const char* tag, const char* attribute,
                                const UrdfElement& owner) {
  const std::string wanted = "<" + std::string(tag) + " " + attribute + "=\"...\"/>";
  const UrdfAttribute* given = element ? element->attribute(attribute) : nullptr;
  if (!element)
    spoil(owner, owner.title(), "a joint must have a <" + std::string(tag) + ">", "", "add " + wanted);
  else if (!given)
    spoil(*element, owner.title(), "<" + std::string(tag) + "> must have '" + attribute + "'", "",
          "write " + wanted);
  else if (given->value.empty())
    spoil(*given, owner.title(), "'" + std::string(attribute) + "' of <" + tag + "> must not be empty", "",
          "");
  return given ? given->value : "";
}

void UrdfReader::read_robot(const UrdfElement& root) {
  model.file = file_;
  // URDFs of real robots have been published without a name, to which nothing refers.
  const UrdfAttribute* name = root.attribute("name");
  if (!name || name->value.empty())
    flaws_.warn(root, "robot", name ? "the name is empty" : "a robot must have a name");
  model.name = name ? name->value : "";
  const UrdfAttribute* version = root.attribute("version");
  static const Names versions = {"1", "1.0", "1.1", "1.2"};
  if (version && std::find(versions.begin(), versions.end(), version->value) == versions.end())
    refuse(root, "unknown version of URDF", quoted(version->value), "known: 1.0, 1.1, 1.2");
}

void UrdfReader::read_link(const UrdfElement& element) {
  const std::string name = name_of(element);
  if (name.empty()) return;
  if (!link_index_.emplace(name, model.links.size()).second) {
    spoil(*element.attribute("name"), element.title(), "duplicate name of a link", "", "rename one of them");
    return;
  }
  model.links.push_back(name);
  Inertia& inertia = model.inertias.emplace_back();
  const UrdfElement* inertial = element.child("inertial");
  if (!inertial) return;
  const std::string key = element.title();
  Eigen::Vector3d rpy = Eigen::Vector3d::Zero();
  read_origin(*inertial, key, inertia.center, rpy);
  if (const UrdfElement* mass = inertial->child("mass")) {
    const auto value = number(*mass, "value", key);
    if (value && *value < 0) spoil(*mass, key, "a mass must not be negative", quoted(shortest(*value)), "");
    inertia.mass = value.value_or(0);
  }
  const UrdfElement* moments = inertial->child("inertia");
  if (!moments) return;
  const auto moment = [&](const char* entry) { return number(*moments, entry, key).value_or(0); };
  Eigen::Matrix3d m;
  m(0, 0) = moment("ixx");
  m(0, 1) = m(1, 0) = moment("ixy");
  m(0, 2) = m(2, 0) = moment("ixz");
  m(1, 1) = moment("iyy");
  m(1, 2) = m(2, 1) = moment("iyz");
  m(2, 2) = moment("izz");
  const Eigen::Matrix3d rotation = (Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) *
                                    Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
                                    Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()))
                                       .toRotationMatrix();
  inertia.about_center = rotation * m * rotation.transpose();
}

void UrdfReader::read_origin(const UrdfElement& owner, const std::string& key, Eigen::Vector3d& xyz,
                             Eigen::Vector3d& rpy) {
  const UrdfElement* origin = owner.child("origin");
  if (!origin) return;
  if (const auto values = numbers<3>(*origin, "xyz", key)) xyz = Eigen::Vector3d(values->data());
  if (const auto values = numbers<3>(*origin, "rpy", key)) rpy = Eigen::Vector3d(values->data());
  if (rpy.cwiseAbs().maxCoeff() > 2 * std::numbers::pi + 1e-3)
    flaws_.warn(*origin, key, "an angle of rpy exceeds a full turn; rpy is in radians: are these degrees?");
}

}  // namespace qerr
