#include <algorithm>
#include <cmath>
#include <numbers>

#include "input/urdf_reader.hpp"
#include "report/robot/parts.hpp"

namespace qerr {

namespace {

constexpr double degrees = 180 / std::numbers::pi;
constexpr std::size_t least_name = 12;

/// `z`, `-y`, or the components of a skew axis.
std::string axis_text(const Joint& joint) {
  static constexpr const char* letters[] = {"x", "y", "z"};
  for (Eigen::Index i = 0; i < 3; ++i)
    if (std::abs(std::abs(joint.axis[i]) - 1) < 1e-6)
      return (joint.axis[i] < 0 ? "-" : "") + std::string(letters[i]);
  std::string text;
  for (Eigen::Index i = 0; i < 3; ++i)
    text += (i ? " " : "") + significant(std::abs(joint.axis[i]) < 5e-3 ? 0 : joint.axis[i], 2);
  return text;
}

bool linear(const Joint& joint) { return joint.type == JointType::prismatic; }

/// In the units of the heading: degrees, or millimetres.
std::string figure(double value, double scale) {
  const std::string text = significant(value * scale, 4);
  return text.size() > 7 ? significant(value * scale, 2) : text;
}

std::vector<std::string> row_of(const Joint& joint) {
  const double scale = linear(joint) ? 1000 : degrees;
  return {joint.name.empty() ? "(no name)" : joint.name,
          std::string(joint_type_name(joint.type)),
          has_axis(joint.type) ? axis_text(joint) : "",
          joint.limits ? figure(joint.limits->lower, scale) : "-",
          joint.limits ? figure(joint.limits->upper, scale) : "-",
          joint.effort_limit ? figure(*joint.effort_limit, 1) : "-",
          joint.velocity_limit ? figure(*joint.velocity_limit, scale) : "-",
          joint.stated_ratio ? figure(*joint.stated_ratio, 1) : ""};
}

/// Width of all columns but the first, with the indentation.
std::size_t width_beside_names(const std::vector<std::vector<std::string>>& rows) {
  std::size_t sum = 2;
  for (std::size_t column = 1; column < rows.front().size(); ++column) {
    std::size_t widest = 0;
    for (const auto& row : rows) widest = std::max(widest, display_width(row[column]));
    sum += widest + 2;
  }
  return sum;
}

std::string mimic_text(const Joint& joint) {
  const Mimic& law = *joint.mimic;
  std::string text = shortened(joint.name, 30) + " = " +
                     (law.multiplier == 1 ? "" : significant(law.multiplier, 4) + " * ") +
                     shortened(law.joint, 30);
  if (law.offset != 0) text += (law.offset < 0 ? " - " : " + ") + significant(std::abs(law.offset), 4);
  return "  " + text + '\n';
}

/// Joints that two motors move together.
std::string couplings(const RobotReport& report, std::size_t width) {
  std::string text;
  for (const StatedCoupling& c : report.robot.couplings)
    text += wrapped(shortened(c.joints[0], 30) + " and " + shortened(c.joints[1], 30) + ": " +
                        escaped(c.type, 40) + ' ' + escaped(c.transmission, 40) + ", " +
                        coupling_text(c.ratios, c.coupling),
                    width, "    ", "  ", LongWords::cut);
  return text.empty() ? "" : "\nCoupled joints: joints = coupling * (motors / gear_ratio)\n" + text;
}

}  // namespace

std::string joint_text(const RobotReport& report, std::size_t width) {
  std::vector<std::vector<std::string>> rows{
      {"joint", "type", "axis", "lower", "upper", "effort", "speed", "ratio"}};
  std::string mimics;
  bool revolute = false, prismatic = false, ratio = false;
  for (const Joint& joint : report.robot.joints) {
    if (joint.type == JointType::fixed) continue;
    rows.push_back(row_of(joint));
    (linear(joint) ? prismatic : revolute) = true;
    ratio = ratio || joint.stated_ratio;
    if (joint.mimic) mimics += mimic_text(joint);
  }
  if (rows.size() == 1) return "";
  if (!ratio)
    for (auto& row : rows) row.pop_back();
  std::size_t others = width_beside_names(rows);
  if (others + least_name > width) {
    for (auto& row : rows)
      if (row[2].find(' ') != std::string::npos) row[2] = "skew";
    others = width_beside_names(rows);
  }
  const std::size_t room = std::max(least_name, width - std::min(width, others));
  for (auto& row : rows) row[0] = shortened(row[0], room);
  const std::string units = std::string(revolute ? "deg, N m, deg/s" : "") +
                            (revolute && prismatic ? "; prismatic: " : "") + (prismatic ? "mm, N, mm/s" : "");
  return aligned(rows) + "  " + units + (ratio ? "; ratio of motor to joint" : "") + '\n' +
         (mimics.empty() ? "" : "\nMimic joints, which need no encoder\n" + mimics) +
         couplings(report, width);
}

}  // namespace qerr
