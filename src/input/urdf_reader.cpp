#include "input/urdf_reader.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "core/suggest.hpp"
#include "core/text.hpp"
#include "qerr/core/quantity.hpp"

namespace qerr {

namespace {

constexpr double least_axis = 1e-6;      // a shorter axis is taken as zero with rounding errors
constexpr double axis_tolerance = 1e-6;  // of the norm, for axes printed with 6 decimals

using Names = std::vector<std::string>;
using Index = std::unordered_map<std::string, std::size_t>;

const std::map<std::string, JointType, std::less<>>& joint_types() {
  static const std::map<std::string, JointType, std::less<>> types = {
      {"revolute", JointType::revolute},   {"continuous", JointType::continuous},
      {"prismatic", JointType::prismatic}, {"fixed", JointType::fixed},
      {"floating", JointType::floating},   {"planar", JointType::planar}};
  return types;
}

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

std::string_view joint_type_name(JointType type) {
  for (const auto& [name, value] : joint_types())
    if (value == type) return name;
  return "";
}

/// Exactly N numbers of an attribute; empty if it is absent or, after reporting a fault, invalid.
template <std::size_t N>
std::optional<std::array<double, N>> UrdfReader::numbers(const UrdfElement& element, const char* name,
                                                         const std::string& key) {
  const UrdfAttribute* attribute = element.attribute(name);
  if (!attribute) return {};
  const auto words = split(attribute->value);
  std::array<double, N> values{};
  bool good = words.size() == N;
  for (std::size_t i = 0; good && i < N; ++i) {
    const auto value = parse_number(words[i]);
    good = value.has_value();
    values[i] = value.value_or(0);
  }
  if (good) return values;
  const bool comma = attribute->value.find(',') != std::string::npos;
  fault(*attribute, key,
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

std::string UrdfReader::name_of(const UrdfElement& element, Index& taken, std::size_t index) {
  const UrdfAttribute* name = element.attribute("name");
  if (!name) {
    fault(element, element.name, "a " + element.name + " must have a name", "", "");
    return {};
  }
  if (name->value.empty())
    fault(*name, element.name, "the name of a " + element.name + " must not be empty", "", "");
  if (!taken.emplace(name->value, index).second)
    fault(*name, element.title(), "duplicate name of a " + element.name, "", "rename one of them");
  return name->value;
}

/// A required attribute of a required child; "" after reporting a fault.
std::string UrdfReader::text_of(const UrdfElement* element, const char* tag, const char* attribute,
                                const UrdfElement& owner) {
  const std::string wanted = "<" + std::string(tag) + " " + attribute + "=\"...\"/>";
  const UrdfAttribute* given = element ? element->attribute(attribute) : nullptr;
  if (!element)
    fault(owner, owner.title(), "a joint must have a <" + std::string(tag) + ">", "", "add " + wanted);
  else if (!given)
    fault(*element, owner.title(), "<" + std::string(tag) + "> must have '" + attribute + "'", "",
          "write " + wanted);
  else if (given->value.empty())
    fault(*given, owner.title(), "'" + std::string(attribute) + "' of <" + tag + "> must not be empty", "",
          "");
  return given ? given->value : "";
}

void UrdfReader::read_robot(const UrdfElement& root) {
  Index none;
  model.file = file_;
  const UrdfAttribute* name = root.attribute("name");
  // URDFs of real robots have been published with an empty name, which nothing refers to.
  if (name && name->value.empty())
    warn(root, "robot", "the name is empty");
  else
    model.name = name_of(root, none, 0);
  const UrdfAttribute* version = root.attribute("version");
  static const Names versions = {"1", "1.0", "1.1", "1.2"};
  if (version && std::find(versions.begin(), versions.end(), version->value) == versions.end())
    fault(*version, root.title(), "unknown version of URDF", quoted(version->value), "known: 1.0, 1.1, 1.2");
}

void UrdfReader::read_link(const UrdfElement& element) {
  model.links.push_back(name_of(element, link_index_, model.links.size()));
  Inertia& inertia = model.inertias.emplace_back();
  const UrdfElement* inertial = element.child("inertial");
  if (!inertial) return;
  const std::string key = element.title();
  Eigen::Vector3d rpy = Eigen::Vector3d::Zero();
  read_origin(*inertial, key, inertia.center, rpy);
  if (const UrdfElement* mass = inertial->child("mass")) {
    const auto value = number(*mass, "value", key);
    if (value && *value < 0) fault(*mass, key, "a mass must not be negative", quoted(shortest(*value)), "");
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

void UrdfReader::read_joint(const UrdfElement& element) {
  const std::string key = element.title();
  WrittenJoint w;
  w.element = &element;
  Joint& joint = w.joint;
  joint.place = {file_, element.line, element.column};
  joint.name = name_of(element, joint_index_, written.size());
  joint.parent = text_of(element.child("parent"), "parent", "link", element);
  joint.child = text_of(element.child("child"), "child", "link", element);
  Eigen::Vector3d xyz = Eigen::Vector3d::Zero();
  read_origin(element, key, xyz, w.rpy);
  joint.origin.translation() = xyz;
  const UrdfAttribute* type = element.attribute("type");
  const auto row = type ? joint_types().find(type->value) : joint_types().end();
  if (row != joint_types().end()) {
    joint.type = row->second;
    read_axis(element, joint);
    read_limit(element, joint);
    read_mimic(element, joint);
  } else {
    Names known;
    for (const auto& entry : joint_types()) known.push_back(entry.first);
    if (!type) fault(element, key, "a joint must have a type", "", did_you_mean("", known));
    if (type) fault(*type, key, "unknown joint type", quoted(type->value), did_you_mean(type->value, known));
  }
  written.push_back(std::move(w));
}

void UrdfReader::read_origin(const UrdfElement& owner, const std::string& key, Eigen::Vector3d& xyz,
                             Eigen::Vector3d& rpy) {
  const UrdfElement* origin = owner.child("origin");
  if (!origin) return;
  if (const auto values = numbers<3>(*origin, "xyz", key)) xyz = Eigen::Vector3d(values->data());
  if (const auto values = numbers<3>(*origin, "rpy", key)) rpy = Eigen::Vector3d(values->data());
  if (rpy.cwiseAbs().maxCoeff() > 2 * std::numbers::pi + 1e-3)
    warn(*origin, key, "an angle of rpy exceeds a full turn; rpy is in radians: are these degrees?");
}

void UrdfReader::read_axis(const UrdfElement& element, Joint& joint) {
  const UrdfElement* axis = element.child("axis");
  if (!axis) return;
  const std::string key = element.title();
  const auto values = numbers<3>(*axis, "xyz", key);
  // Exporters write 0 0 0 for joints without an axis.
  if (!has_axis(joint.type)) return;
  if (!axis->attribute("xyz")) fault(*axis, key, "<axis> must have 'xyz'", "", "write <axis xyz=\"X Y Z\"/>");
  if (!values) return;
  joint.axis = Eigen::Vector3d(values->data());
  const double norm = joint.axis.stableNorm();
  const std::string text = qerr::quoted(axis->attribute("xyz")->value);
  if (!(norm >= least_axis)) {
    fault(*axis->attribute("xyz"), key, "the axis of a joint must not be zero", text, "give its direction");
  } else if (std::abs(norm - 1) > axis_tolerance) {
    warn(*axis, key, "the axis " + text + " has norm " + shortest(norm) + "; it is normalised");
  }
}

void UrdfReader::read_limit(const UrdfElement& element, Joint& joint) {
  const std::string key = element.title();
  const UrdfElement* limit = element.child("limit");
  const bool ranged = has_range(joint.type);
  if (!limit) {
    if (ranged)
      warn(element, key, "a " + std::string(joint_type_name(joint.type)) + " joint should have a <limit>");
    return;
  }
  const auto lower = number(*limit, "lower", key), upper = number(*limit, "upper", key);
  for (const char* name : {"effort", "velocity"}) {
    const auto value = number(*limit, name, key);
    if (ranged && !limit->attribute(name))
      fault(*limit, key, "<limit> must have '" + std::string(name) + "'", "", "");
    if (value && *value < 0)
      fault(*limit->attribute(name), key, "'" + std::string(name) + "' of <limit> must not be negative",
            quoted(shortest(*value)), "");
    // Exporters write 0 for an unknown limit.
    if (value && *value > 0)
      (std::string_view(name) == "effort" ? joint.effort_limit : joint.velocity_limit) = *value;
  }
  if (!ranged || (!lower && !upper)) return;
  joint.limits =
      Limits{lower.value_or(0), upper.value_or(0)};  // an absent limit is 0 by the URDF specification
  if (joint.limits->lower > joint.limits->upper)
    fault(*limit, key, "the lower limit must not exceed the upper one",
          "lower " + shortest(joint.limits->lower) + (lower ? "" : " (the default)") + " and upper " +
              shortest(joint.limits->upper) + (upper ? "" : " (the default)"),
          lower && upper ? "exchange them" : "give both");
}

void UrdfReader::read_mimic(const UrdfElement& element, Joint& joint) {
  const UrdfElement* mimic = element.child("mimic");
  if (!mimic) return;
  const std::string key = element.title();
  Mimic law;
  law.joint = text_of(mimic, "mimic", "joint", element);
  law.multiplier = number(*mimic, "multiplier", key).value_or(1);
  law.offset = number(*mimic, "offset", key).value_or(0);
  if (joint.type == JointType::fixed) {
    warn(*mimic, key, "a fixed joint cannot mimic another; <mimic> is ignored");
    return;
  }
  if (!has_one_coordinate(joint.type))
    fault(*mimic, key, "a " + std::string(joint_type_name(joint.type)) + " joint cannot mimic another", "",
          "");
  if (law.multiplier == 0) warn(*mimic, key, "the multiplier of <mimic> is 0: the joint never moves");
  joint.mimic = std::move(law);
}

}  // namespace qerr
