#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "input/urdf_reader.hpp"
#include "qerr/core/quantity.hpp"

namespace qerr {

namespace {

using Names = std::vector<std::string>;

/// At most six names, for a message.
std::string listed(const Names& names, const char* between = ", ") {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i == 6) return text + between + "...";
    text += (i ? between : "") + qerr::quoted(names[i]);
  }
  return text;
}

/// A suggestion for a misspelt name; none for robots with thousands of names, since it compares all of them.
std::string suggestion(const std::string& word, const Names& known) {
  return known.size() > 5000 ? "" : did_you_mean(word, known);
}

constexpr double least_axis = 1e-6;      // a shorter axis is taken as zero with rounding errors
constexpr double axis_tolerance = 1e-6;  // of the norm, for axes printed with 6 decimals

// 1600 turns, or 10 km: exporters write such bounds, up to 1e16 and infinity, for joints without any.
constexpr double no_bound = 1e4;  // [rad or m]

bool is_infinite(std::string_view text) {
  if (text.starts_with('-') || text.starts_with('+')) text.remove_prefix(1);
  if (text.starts_with('.')) text.remove_prefix(1);
  const std::string word = lower_case(text);
  return word == "inf" || word == "infinity";
}

const std::vector<std::pair<std::string, JointType>>& joint_types() {
  static const std::vector<std::pair<std::string, JointType>> types = {
      {"continuous", JointType::continuous}, {"fixed", JointType::fixed},
      {"floating", JointType::floating},     {"planar", JointType::planar},
      {"prismatic", JointType::prismatic},   {"revolute", JointType::revolute}};
  return types;
}

}  // namespace

/// Excludes a joint from the tree if it does not join two links of the robot, or if its child has a parent
/// already.
void UrdfReader::check_ends(WrittenJoint& w) {
  const Joint& joint = w.joint;
  const std::string key = w.element->title();
  const std::size_t index = static_cast<std::size_t>(&w - written.data());
  for (const auto& [tag, link] : {std::pair("parent", &joint.parent), std::pair("child", &joint.child)}) {
    if (link_index_.contains(*link)) continue;
    w.in_tree = false;
    if (link->empty()) continue;  // reported where it was read
    Flaw& flaw = spoil(*w.element->child(tag)->attribute("link"), key,
                       "the " + std::string(tag) + " is not a link of this robot", qerr::quoted(*link),
                       suggestion(*link, model.links));
    if (tag == std::string_view("parent") && joint.type != JointType::fixed)
      flaw.below_missing_joint = joint.child;
  }
  if (joint.child.empty()) return;
  const UrdfAttribute& child = *w.element->child("child")->attribute("link");
  if (joint.child == joint.parent) {
    spoil(child, key, "parent and child must be different links", qerr::quoted(joint.child) + " for both",
          "");
    w.in_tree = false;
  }
  if (!w.in_tree) return;
  const auto [first, fresh] = parent_joint_.emplace(joint.child, index);
  if (fresh) return;
  w.in_tree = false;
  const std::string other = written[first->second].joint.name;
  spoil(child, key,
        "a link must have one parent; " + qerr::quoted(joint.child) + " is already the child of joint " +
            qerr::quoted(other),
        "", "")
      .joints.push_back(other);
}

/// Makes the graph a forest. If every link has at most one parent, only cycles remain to be cut.
void UrdfReader::check_tree(const UrdfElement& root) {
  for (WrittenJoint& w : written) {
    flaws_.concern_joint(w.joint.name);
    check_ends(w);
  }
  flaws_.concern_document();
  std::unordered_map<std::string, std::size_t> visited;  // link -> the first walk that visited it
  for (std::size_t walk = 0; walk < model.links.size(); ++walk) {
    std::string link = model.links[walk];
    Names path;
    for (auto up = parent_joint_.find(link); visited.emplace(link, walk).second && up != parent_joint_.end();
         up = parent_joint_.find(link)) {
      path.push_back(link);
      link = written[up->second].joint.parent;
    }
    const auto repeat = std::ranges::find(path, link);
    if (repeat == path.end()) continue;
    WrittenJoint& joint = written[parent_joint_.at(link)];
    Names loop(repeat, path.end());
    loop.push_back(link);
    Flaw& flaw = spoil(*joint.element, joint.element->title(), "the links form a loop; a URDF must be a tree",
                       listed(loop, " under "), "");
    for (const std::string& each : loop) flaw.joints.push_back(written[parent_joint_.at(each)].joint.name);
    joint.in_tree = false;
    parent_joint_.erase(link);
  }
  // Where a joint is excluded, further roots are its consequence.
  if (std::ranges::all_of(written, &WrittenJoint::in_tree)) check_roots(root);
}

void UrdfReader::check_roots(const UrdfElement& root) {
  Names roots;
  for (const std::string& link : model.links)
    if (!parent_joint_.contains(link)) roots.push_back(link);
  if (roots.size() < 2) return;
  for (const UrdfElement& child : root.children) {
    const UrdfAttribute* name = child.attribute("name");  // null in a link that is reported for that
    if (child.name != "link" || !name || name->value != roots[1]) continue;
    spoil(child, child.title(), "a robot must have one root link",
          counted(roots.size(), "root") + ": " + listed(roots), "join them by a joint, or name robot.base");
  }
}

/// Reports a mimic that cannot be followed: the joint then has a coordinate of its own, and is spoilt.
void UrdfReader::drop_mimic(WrittenJoint& w, std::string rule, std::string found, std::string remedy) {
  const UrdfElement& mimic = *w.element->child("mimic");
  const UrdfAttribute* target = mimic.attribute("joint");
  flaws_.concern_joint(w.joint.name);
  if (target)
    spoil(*target, w.element->title(), std::move(rule), std::move(found), std::move(remedy));
  else
    spoil(mimic, w.element->title(), std::move(rule), std::move(found), std::move(remedy));
  w.joint.mimic.reset();
}

void UrdfReader::check_mimics() {
  Names names;
  for (const WrittenJoint& w : written) names.push_back(w.joint.name);
  for (WrittenJoint& w : written) {
    if (!w.joint.mimic) continue;
    const std::string& target = w.joint.mimic->joint;
    const auto found = joint_index_.find(target);
    if (target.empty()) {
      w.joint.mimic.reset();  // reported where it was read
    } else if (found == joint_index_.end()) {
      drop_mimic(w, "unknown joint to mimic", qerr::quoted(target), suggestion(target, names));
    } else if (const WrittenJoint& master = written[found->second]; !has_one_coordinate(master.joint.type)) {
      drop_mimic(w, "the joint to mimic must be revolute, continuous or prismatic",
                 qerr::quoted(target) + ", which is " + std::string(joint_type_name(master.joint.type)), "");
    } else if (!master.in_tree) {
      drop_mimic(w, "the joint to mimic is not part of the tree", qerr::quoted(target), "");
    }
  }
  check_mimic_loops();
  flaws_.concern_document();
}

void UrdfReader::check_mimic_loops() {
  std::vector<std::size_t> visited(written.size(), written.size());  // the first walk that visited a joint
  const auto next = [&](std::size_t joint) { return joint_index_.at(written[joint].joint.mimic->joint); };
  for (std::size_t walk = 0; walk < written.size(); ++walk) {
    std::size_t at = walk;
    for (; written[at].joint.mimic && visited[at] == written.size(); at = next(at)) visited[at] = walk;
    if (!written[at].joint.mimic || visited[at] != walk) continue;
    Names loop{written[at].joint.name};
    for (std::size_t other = at; loop.size() < 2 || other != at;)
      loop.push_back(written[other = next(other)].joint.name);
    drop_mimic(written[at],
               loop.size() == 2 ? "a joint cannot mimic itself" : "joints mimic each other in a loop",
               listed(loop, " mimics "), "");
  }
}

// Reading of <joint>: type, axis, limits and mimic.

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
  const auto row =
      std::ranges::find_if(joint_types(), [&](const auto& t) { return type && t.first == type->value; });
  if (row != joint_types().end()) {
    joint.type = row->second;
    read_axis(element, joint);
    read_limit(element, joint);
    read_mimic(element, joint);
    if (joint.type == JointType::planar)
      flaws_.warn(element, key, "a planar joint is read as joints of its own for x, y and yaw", "",
                  "state an encoder for each: " + quoted(joint.name + "/*") +
                      "; the odometry of wheels is not among what is computed");
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
