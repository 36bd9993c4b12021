#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "core/text.hpp"
#include "input/read_sections.hpp"

/// Reads the key `robot.dh` of a spec: a table of Denavit and Hartenberg.
namespace qerr {

namespace {

constexpr double two_pi = 2 * std::numbers::pi;

/// theta or d of a row: a constant, or a joint's variable with sign and offset, such as `q2 - 90 deg`.
struct DhEntry {
  std::string joint;  ///< empty: a constant
  double sign = 1, offset = 0;
};

bool is_variable(std::string_view word) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  return !word.empty() && letter(word.front()) &&
         std::ranges::all_of(word, [&](char c) { return letter(c) || (c >= '0' && c <= '9') || c == '.'; });
}

/// `-q2`, or a variable without sign. @returns whether the word is one
bool read_variable(std::string_view word, DhEntry& entry) {
  word = trimmed(word);
  double sign = 1;
  if (!word.empty() && (word.front() == '-' || word.front() == '+')) {
    sign = word.front() == '-' ? -1 : 1;
    word = trimmed(word.substr(1));
  }
  if (!is_variable(word)) return false;
  entry.joint = std::string(word);
  entry.sign = sign;
  return true;
}

/// A quantity of the table, written with its sign behind it.
std::optional<double> quantity_of(std::string text, Dimension dimension) {
  if (const std::size_t blank = text.find_first_not_of(' ', 1); !text.empty() && blank != std::string::npos)
    if (text.front() == '-' || text.front() == '+') text.erase(1, blank - 1);
  std::string why;
  const auto quantity = parse_quantity(trimmed(text), why);
  if (!quantity || quantity->dimension.value_or(dimension) != dimension) return std::nullopt;
  return quantity->value;
}

DhEntry read_entry(const Object& o, std::string_view key, Dimension dimension) {
  DhEntry entry;
  if (!o.has(key)) return entry;
  const Field f = o.at(key);
  const std::string text = f.node->type == Node::Type::scalar ? f.node->text : "";
  std::string why;
  if (parse_quantity(text, why)) {
    entry.offset = read_number(f, {.name = key, .dimension = dimension});
    return entry;
  }
  if (read_variable(text, entry)) return entry;
  for (std::size_t at = 1; at < text.size(); ++at) {
    if (text[at] != '+' && text[at] != '-') continue;
    const std::string before = text.substr(0, at), behind = text.substr(at);
    for (const auto& [variable, quantity] : {std::pair(before, behind), std::pair(behind, before)})
      if (const auto offset = quantity_of(quantity, dimension); offset && read_variable(variable, entry)) {
        entry.offset = *offset;
        return entry;
      }
  }
  const std::string example =
      dimension == dimension::angle ? "30 deg, q2, or q2 - 90 deg" : "300 mm, q3, or q3 + 0.1 m";
  f.refuse("must be a quantity, or a joint's variable with an offset", "write " + example);
}

Eigen::Isometry3d turn(double angle, const Eigen::Vector3d& axis) {
  return Eigen::Isometry3d(Eigen::AngleAxisd(angle, axis));
}

/// An angle of the table; one without unit beyond a turn was meant in degrees.
double within_turn(const Field& f, double angle) {
  if (std::abs(angle) > two_pi)
    f.refuse("an angle of a DH table is within a turn; without a unit it is in rad", "write 90 deg, or pi/2");
  return angle;
}

Eigen::Isometry3d shift(double x, double z) { return Eigen::Isometry3d(Eigen::Translation3d(x, 0, z)); }

struct DhRow {
  Joint joint;  // its origin: of what the row has before the motion
  Eigen::Isometry3d behind = Eigen::Isometry3d::Identity();  // the motion
};

/// [lower, upper] of a joint without URDF.
Limits read_limits_of_joint(const Field& f, bool prismatic) {
  const std::string example =
      prismatic ? "[lower, upper], such as [0, 300 mm]" : "[lower, upper], such as [-90 deg, 90 deg]";
  const std::vector<Field> ends = read_list(f, example);
  if (ends.size() != 2) f.refuse("limits must be two numbers", "write " + example);
  const Parameter row{.name = "limits", .coordinate = true};
  const Dimension dimension = prismatic ? dimension::length : dimension::angle;
  const Limits limits{read_number(ends[0], row, dimension), read_number(ends[1], row, dimension)};
  if (limits.lower > limits.upper) f.refuse("the lower limit is above the upper one", "write " + example);
  return limits;
}

/// The transforms of a row around its motion.
///
/// standard: R_z(theta) T_z(d) T_x(a) R_x(alpha); modified (Craig): R_x(alpha) T_x(a) R_z(theta) T_z(d),
/// where alpha and a are those of the link before.
DhRow read_row(const Field& f, bool modified) {
  const Object o(f, spec_format::dh_row);
  const DhEntry theta = read_entry(o, "theta", dimension::angle), d = read_entry(o, "d", dimension::length);
  if (o.has("theta")) within_turn(o.at("theta"), theta.offset);
  const double a = o.number("a").value_or(0), alpha = o.number("alpha").value_or(0);
  if (o.has("alpha")) within_turn(o.at("alpha"), alpha);
  if (!theta.joint.empty() && !d.joint.empty())
    f.refuse("a row has one variable, theta or d",
             "give the other a value, and a row of its own to a second joint");
  DhRow row;
  const Eigen::Isometry3d link = modified ? turn(alpha, Eigen::Vector3d::UnitX()) * shift(a, 0)
                                          : shift(a, 0) * turn(alpha, Eigen::Vector3d::UnitX());
  if (modified) row.joint.origin = link;
  // Rotation about z and translation along it commute: the constant parts may stand before the motion.
  row.joint.origin = row.joint.origin * turn(theta.offset, Eigen::Vector3d::UnitZ()) * shift(0, d.offset);
  if (!modified) row.behind = link;
  const bool prismatic = !d.joint.empty();
  row.joint.name = prismatic ? d.joint : theta.joint;
  row.joint.axis = (prismatic ? d.sign : theta.sign) * Eigen::Vector3d::UnitZ();
  row.joint.place = f.node->place;
  if (o.has("limits")) row.joint.limits = read_limits_of_joint(o.at("limits"), prismatic);
  row.joint.velocity_limit = o.number("velocity", prismatic ? dimension::speed : dimension::angular_speed);
  if (row.joint.name.empty()) {
    for (const char* key : {"limits", "velocity"})
      if (o.has(key))
        o.at(key).refuse("the row has no variable, so that nothing moves", "write theta: q1, or d: q1");
  } else {
    row.joint.type = prismatic          ? JointType::prismatic
                     : row.joint.limits ? JointType::revolute
                                        : JointType::continuous;
  }
  if (row.joint.type == JointType::continuous) row.joint.limits = Limits{-std::numbers::pi, std::numbers::pi};
  return row;
}

/// A table without `convention` that looks like a modified one: its first row has no link, its last one has.
bool looks_modified(const std::vector<Field>& rows) {
  const auto has_link = [](const Field& f) {
    const Object o(f, spec_format::dh_row);
    return o.number("a").value_or(0) != 0 || o.number("alpha").value_or(0) != 0;
  };
  return rows.size() > 1 && !has_link(rows.front()) && has_link(rows.back());
}

Eigen::Vector3d read_three(const Object& o, std::string_view key, Dimension dimension) {
  Eigen::Vector3d v = Eigen::Vector3d::Zero();
  if (!o.has(key)) return v;
  const Field list = o.at(key);
  const std::vector<Field> items = read_list(list);
  if (items.size() != 3) list.refuse("needs three numbers", "write [0, 0, 0]");
  for (Eigen::Index i = 0; i < 3; ++i) v[i] = read_number(items[i], {.name = key, .dimension = dimension});
  return v;
}

}  // namespace

RobotModel read_dh(const Field& f, const std::string& convention, const std::string& file,
                   std::vector<std::string>& warnings) {
  const std::vector<Field> rows = read_list(f, "[{theta: q1, d: 0.3, a: 0, alpha: 90 deg}, ...]");
  RobotModel model;
  model.name = file == "-" ? "robot" : std::filesystem::path(file).stem().string();
  model.file = file;
  model.links = {"base"};
  Eigen::Isometry3d before = Eigen::Isometry3d::Identity();
  Faults faults;
  for (std::size_t i = 0; i < rows.size(); ++i)
    faults.guard([&] {
      DhRow row = read_row(rows[i], convention == "modified");
      for (const Joint& other : model.joints)
        if (!row.joint.name.empty() && other.name == row.joint.name)
          rows[i].refuse("two rows have the variable " + quoted(other.name), "name each joint once");
      if (row.joint.name.empty()) row.joint.name = "row " + std::to_string(i + 1);
      row.joint.origin = before * row.joint.origin;
      before = row.behind;
      row.joint.parent = model.links.back();
      row.joint.child = "link " + std::to_string(i + 1);
      model.links.push_back(row.joint.child);
      model.joints.push_back(std::move(row.joint));
    });
  faults.raise();
  if (convention.empty() && looks_modified(rows))
    warnings.push_back(
        "robot.dh: the first row has no a and alpha, the last one has: is this a table of modified "
        "parameters (Craig)? It is read as a standard one; write convention: modified, or standard");
  Joint flange;
  flange.name = "flange";
  flange.parent = model.links.back();
  flange.child = "tip";
  flange.origin = before;
  flange.place = f.node->place;
  model.links.push_back("tip");
  model.joints.push_back(flange);
  model.inertias.resize(model.links.size());
  return model;
}

RobotModel read_joint(const Field& f, const std::string& file) {
  const Object o(f, spec_format::joint);
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
  if (prismatic) o.at("radius").refuse("only a revolute joint has a radius", "leave it out");
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

/// Reads the keys `robot.tool` and `robot.tracker` of a spec.
Eigen::Isometry3d read_pose(const Field& f) {
  const Object o(f, spec_format::pose);
  const Eigen::Vector3d rpy = read_three(o, "rpy", dimension::angle);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = read_three(o, "xyz", dimension::length);
  pose.linear() = (Eigen::AngleAxisd(rpy[2], Eigen::Vector3d::UnitZ()) *
                   Eigen::AngleAxisd(rpy[1], Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(rpy[0], Eigen::Vector3d::UnitX()))
                      .toRotationMatrix();
  return pose;
}

Eigen::Vector3d roll_pitch_yaw(const Eigen::Matrix3d& r) {
  const double level = std::hypot(r(0, 0), r(1, 0));
  if (level < 1e-12) return {0, std::atan2(-r(2, 0), level), std::atan2(-r(0, 1), r(1, 1))};
  return {std::atan2(r(2, 1), r(2, 2)), std::atan2(-r(2, 0), level), std::atan2(r(1, 0), r(0, 0))};
}

}  // namespace qerr
