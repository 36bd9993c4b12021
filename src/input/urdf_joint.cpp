#include <algorithm>
#include <cmath>

#include "core/suggest.hpp"
#include "core/text.hpp"
#include "input/urdf_reader.hpp"
#include "qerr/core/quantity.hpp"

// Reading of <joint>: type, axis, limits and mimic.
namespace qerr {

namespace {

constexpr double least_axis = 1e-6;      // a shorter axis is taken as zero with rounding errors
constexpr double axis_tolerance = 1e-6;  // of the norm, for axes printed with 6 decimals

// 1600 turns, or 10 km: exporters write such bounds, up to 1e16 and infinity, for joints without any.
constexpr double no_bound = 1e4;  // [rad or m]

bool is_infinite(std::string_view text) {
  if (text.starts_with('-') || text.starts_with('+')) text.remove_prefix(1);
  if (text.starts_with('.')) text.remove_prefix(1);
  std::string word;
  for (const char c : text) word += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return word == "inf" || word == "infinity";
}

}  // namespace

const std::vector<std::pair<std::string, JointType>>& joint_types() {
  static const std::vector<std::pair<std::string, JointType>> types = {
      {"continuous", JointType::continuous}, {"fixed", JointType::fixed},
      {"floating", JointType::floating},     {"planar", JointType::planar},
      {"prismatic", JointType::prismatic},   {"revolute", JointType::revolute}};
  return types;
}

std::string_view joint_type_name(JointType type) {
  for (const auto& [name, value] : joint_types())
    if (value == type) return name;
  return "";
}

void UrdfReader::read_joint(const UrdfElement& element) {
  const std::string key = element.title();
  WrittenJoint w;
  w.element = &element;
  Joint& joint = w.joint;
  joint.place = {file_, element.line, element.column};
  joint.name = name_of(element);
  if (!joint_index_.emplace(joint.name, written.size()).second && !joint.name.empty())
    spoil(*element.attribute("name"), key, "duplicate name of a joint", "", "rename one of them");
  joint.parent = text_of(element.child("parent"), "parent", "link", element);
  joint.child = text_of(element.child("child"), "child", "link", element);
  Eigen::Vector3d xyz = Eigen::Vector3d::Zero();
  read_origin(element, key, xyz, w.rpy);
  joint.origin.translation() = xyz;
  const UrdfAttribute* type = element.attribute("type");
  const auto row = std::find_if(joint_types().begin(), joint_types().end(),
                                [&](const auto& t) { return type && t.first == type->value; });
  if (row != joint_types().end()) {
    joint.type = row->second;
    read_axis(element, joint);
    read_limit(element, joint);
    read_mimic(element, joint);
  } else {
    std::vector<std::string> known;
    for (const auto& entry : joint_types()) known.push_back(entry.first);
    if (!type) spoil(element, key, "a joint must have a type", "", did_you_mean("", known));
    if (type) spoil(*type, key, "unknown joint type", quoted(type->value), did_you_mean(type->value, known));
  }
  written.push_back(std::move(w));
}

void UrdfReader::read_axis(const UrdfElement& element, Joint& joint) {
  const UrdfElement* axis = element.child("axis");
  if (!axis) return;
  const std::string key = element.title();
  const auto values = numbers<3>(*axis, "xyz", key);
  // Exporters write 0 0 0 for joints without an axis.
  if (!has_axis(joint.type)) return;
  if (!axis->attribute("xyz")) spoil(*axis, key, "<axis> must have 'xyz'", "", "write <axis xyz=\"X Y Z\"/>");
  if (!values) return;
  joint.axis = Eigen::Vector3d(values->data());
  const double norm = joint.axis.stableNorm();
  const std::string text = qerr::quoted(axis->attribute("xyz")->value);
  if (!(norm >= least_axis)) {
    spoil(*axis->attribute("xyz"), key, "the axis of a joint must not be zero", text, "give its direction");
    joint.axis = Eigen::Vector3d::UnitX();
  } else if (std::abs(norm - 1) > axis_tolerance) {
    flaws_.warn(*axis, key, "the axis " + text + " has norm " + shortest(norm) + "; it is normalised");
  }
}

/// `lower` or `upper`: infinite where the URDF says that there is no bound, empty where it says nothing.
std::optional<double> UrdfReader::read_bound(const UrdfElement& limit, const char* name, const Joint& joint) {
  const UrdfAttribute* given = limit.attribute(name);
  if (given && is_infinite(given->value)) return HUGE_VAL;
  const auto value = number(limit, name, "joint " + quoted(joint.name));
  return value && std::abs(*value) >= no_bound ? HUGE_VAL : value;
}

/// `effort` or `velocity`, on which no bound depends; empty if it is not given or is not a strength.
std::optional<double> UrdfReader::read_strength(const UrdfElement& limit, const char* name,
                                                const Joint& joint) {
  const std::string key = "joint " + quoted(joint.name), what = "'" + std::string(name) + "'";
  const UrdfAttribute* given = limit.attribute(name);
  if (!given) {
    if (has_range(joint.type)) flaws_.warn(limit, key, "<limit> must have " + what);
    return {};
  }
  const auto value = parse_number(given->value);
  if (!value || *value < 0) {
    if (!is_infinite(given->value) || given->value.starts_with('-'))
      flaws_.warn(*given, key,
                  what + " of <limit> must " + (value ? "not be negative" : "be a finite number"),
                  quoted(given->value), "it is ignored");
    return {};
  }
  // Exporters write 0 for an unknown limit.
  return *value > 0 ? value : std::nullopt;
}

void UrdfReader::read_limit(const UrdfElement& element, Joint& joint) {
  const UrdfElement* limit = element.child("limit");
  const bool ranged = has_range(joint.type);
  if (!limit) {
    if (ranged)
      flaws_.warn(element, element.title(),
                  "a " + std::string(joint_type_name(joint.type)) + " joint should have a <limit>");
    return;
  }
  const auto lower = read_bound(*limit, "lower", joint), upper = read_bound(*limit, "upper", joint);
  joint.effort_limit = read_strength(*limit, "effort", joint);
  joint.velocity_limit = read_strength(*limit, "velocity", joint);
  if (!ranged || (!lower && !upper)) return;
  // An absent bound is 0 by the URDF specification.
  const Limits given{lower.value_or(0), upper.value_or(0)};
  if (std::isinf(given.lower) || std::isinf(given.upper)) {
    const auto text = [&](const char* name) {
      const UrdfAttribute* end = limit->attribute(name);
      return end ? end->value : "0";
    };
    flaws_.warn(*limit, element.title(), "a range of this size is read as no limit",
                quoted(text("lower") + " to " + text("upper")));
    return;
  }
  if (given.lower <= given.upper) {
    joint.limits = given;
    return;
  }
  const auto shown = [](double value, bool written) {
    return shortest(value) + (written ? "" : " (the default)");
  };
  spoil(*limit, element.title(), "the lower limit must not exceed the upper one",
        "lower " + shown(given.lower, lower.has_value()) + " and upper " +
            shown(given.upper, upper.has_value()),
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
    flaws_.warn(*mimic, key, "a fixed joint cannot mimic another; <mimic> is ignored");
    return;
  }
  if (!has_one_coordinate(joint.type)) {
    spoil(*mimic, key, "a " + std::string(joint_type_name(joint.type)) + " joint cannot mimic another", "",
          "");
    return;
  }
  if (law.multiplier == 0) flaws_.warn(*mimic, key, "the multiplier of <mimic> is 0: the joint never moves");
  joint.mimic = std::move(law);
}

}  // namespace qerr
