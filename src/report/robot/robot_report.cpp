#include "qerr/report/robot_report.hpp"

#include <limits>
#include <numbers>

#include "core/sha256.hpp"
#include "input/joint_entries.hpp"
#include "input/joint_table.hpp"
#include "input/urdf_reader.hpp"
#include "kinematics/tree.hpp"
#include "qerr/input/first_spec.hpp"
#include "report/csv_text.hpp"
#include "report/formats.hpp"
#include "report/json_header.hpp"
#include "report/robot/parts.hpp"

namespace qerr {

RobotReport robot_report(RobotModel robot, const std::string& text, const std::string& base,
                         const std::string& tip) {
  RobotReport report;
  report.robot = std::move(robot);
  report.sha256 = sha256(text);
  report.roots = Tree(report.robot).roots();
  report.ends = tree_ends(report.robot, base);
  try {
    const Chain chain = first_chain(report.robot, base, tip);
    report.base = chain.base;
    report.tip = chain.tip;
    if (find_path(report.robot, chain.base, chain.tip).upward > 0) report.ends = tree_ends(report.robot);
  } catch (const Error& e) {
    if (!base.empty() || !tip.empty()) throw;
    report.obstacle = e.what();
  }
  return report;
}

PoseAtJoints pose_at(const RobotModel& robot, const Chain& chain, const std::vector<std::string>& values) {
  PoseAtJoints at{chain.base, chain.tip, {}, {}, {}};
  for (const IndependentJoint& joint : chain.independent) at.joints.emplace_back(joint, 0);
  for (const std::string& text : values) {
    const std::size_t sign = text.find('=');
    if (sign == std::string::npos)
      throw Error(
          Fault{{}, "--at", "needs a joint and its value", quoted(text), "write --at q1=30deg,q2=0.1"});
    const std::size_t index = find_joint(robot, chain, text.substr(0, sign), {}, "--at");
    const IndependentJoint& joint = at.joints[index].first;
    const Dimension dimension = joint.prismatic() ? dimension::length : dimension::angle;
    std::string why;
    const auto value = parse_quantity(text.substr(sign + 1), why);
    if (!value || value->dimension.value_or(dimension) != dimension)
      throw Error(Fault{{}, "--at", "must be " + name_of(dimension), quoted(text), unit_remedy(dimension)});
    at.joints[index].second = value->value;
    const double free = joint.prismatic() ? std::numeric_limits<double>::infinity() : 2 * std::numbers::pi;
    const Limits limits = joint.limits.value_or(Limits{-free, free});
    if (inside(value->value, limits)) continue;
    at.warnings.push_back("--at " + text + ": " +
                          (joint.limits
                               ? "joint '" + joint.name + "' is outside its limits " + text_of(limits, joint)
                               : "more than a turn of joint '" + joint.name + "'") +
                          (joint.prismatic() || value->dimension
                               ? ""
                               : "; degrees need their unit: " + quoted(joint.name + "=90deg")));
  }
  Eigen::VectorXd q(static_cast<Eigen::Index>(at.joints.size()));
  for (Eigen::Index i = 0; i < q.size(); ++i) q[i] = at.joints[static_cast<std::size_t>(i)].second;
  at.pose = forward_kinematics(chain, q);
  return at;
}

std::string to_csv(const RobotReport& report, const Style&) {
  std::string out =
      "joint,type,parent,child,axis_x,axis_y,axis_z,unit,lower,upper,effort,velocity,ratio,mimic,multiplier,"
      "offset\r\n";
  for (const Joint& joint : report.robot.joints) {
    if (joint.type == JointType::fixed) continue;
    const Json json = json_of(joint);
    out += csv_cells(json, {"name", "type", "parent", "child"});
    for (const double component : joint.axis) out += ',' + shortest(component);
    out += ',' +
           csv_cells(json, {"unit", "limits.lower", "limits.upper", "effort", "velocity", "ratio",
                            "mimic.joint", "mimic.multiplier", "mimic.offset"}) +
           "\r\n";
  }
  return out;
}

namespace {

/// A member of a joint that moves; empty for a fixed one.
template <class T>
auto moving(T Joint::*value) {
  return [value](const Joint& j) { return only_if(j.type != JointType::fixed, j.*value); };
}

using ReportedEnd = In<TreeEnd, RobotReport>;

std::vector<double> position(const PoseAtJoints& at) {
  return {at.pose.translation().begin(), at.pose.translation().end()};
}

/// x, y, z, w with w >= 0.
std::vector<double> quaternion(const PoseAtJoints& at) {
  Eigen::Quaterniond q(at.pose.linear());
  if (q.w() < 0) q.coeffs() *= -1;
  return {q.x(), q.y(), q.z(), q.w()};
}

struct FirstSpec {
  std::string base, tip;
};

}  // namespace

RowsOf<Limits> rows(Of<Limits>) {
  return {{"lower", &Limits::lower, nullable}, {"upper", &Limits::upper, nullable}};
}

RowsOf<Mimic> rows(Of<Mimic>) {
  return {{"joint", &Mimic::joint}, {"multiplier", &Mimic::multiplier}, {"offset", &Mimic::offset}};
}

RowsOf<Joint> rows(Of<Joint>) {
  return {{"name", &Joint::name},
          {"type", [](auto& j) { return joint_type_name(j.type); }},
          {"parent", &Joint::parent},
          {"child", &Joint::child},
          {"unit",
           [](auto& j) {
             return j.type == JointType::fixed ? "" : j.type == JointType::prismatic ? "m" : "rad";
           },
           one_of({"m", "rad"}), "of a moving joint, as the members below", optional},
          {"axis", moving(&Joint::axis), "in the frame of the joint", optional},
          {"limits", moving(&Joint::limits), "null: none", optional},
          {"effort", moving(&Joint::effort_limit), optional},
          {"velocity", moving(&Joint::velocity_limit), optional},
          {"ratio", moving(&Joint::stated_ratio), "that the URDF states", optional},
          {"mimic", moving(&Joint::mimic), optional}};
}

RowsOf<StatedCoupling> rows(Of<StatedCoupling>) {
  return {{"transmission", &StatedCoupling::transmission},
          {"type", &StatedCoupling::type},
          {"joints", &StatedCoupling::joints},
          {"ratios", &StatedCoupling::ratios, "of the two motors"},
          {"coupling", [](auto& c) { return nested(c.coupling); }, "joints = coupling * (motors / ratios)"}};
}

RowsOf<ReportedEnd> rows(Of<ReportedEnd>) {
  return {{"tip", &TreeEnd::tip},
          {"base", &TreeEnd::base},
          {"moving_joints", [](auto& end) { return end->joints.size(); }},
          {"kind", [](auto& end) { return end_kind_name(end->kind); }},
          {"joints", [](auto& end) {
             return end->joints |
                    std::views::transform([&](std::size_t i) { return end.whole.robot.joints[i].name; });
           }}};
}

RowsOf<Flaw> rows(Of<Flaw>) {
  return {{"severity", [](auto& f) { return f.spoils ? "error" : "warning"; }, one_of({"error", "warning"})},
          {"message", [](auto& f) { return format({f.fault}); }}};
}

RowsOf<PoseAtJoints> rows(Of<PoseAtJoints>) {
  return {{"base", &PoseAtJoints::base},
          {"tip", &PoseAtJoints::tip},
          {"joints",
           [](auto& at) {
             std::map<std::string, double> values;
             for (const auto& [joint, value] : at.joints) values[joint.name] = value;
             return values;
           },
           "rad or m"},
          {"position", position, "of the tip in the frame of the base [m]"},
          {"quaternion", quaternion, "x, y, z, w"},
          {"rpy", [](auto& at) { return roll_pitch_yaw(at.pose.linear()); },
           "R_z(yaw) R_y(pitch) R_x(roll) [rad]"},
          {"matrix", [](auto& at) { return nested(at.pose.matrix()); }, "homogeneous, base from tip"}};
}

RowsOf<FirstSpec> rows(Of<FirstSpec>) { return {{"base", &FirstSpec::base}, {"tip", &FirstSpec::tip}}; }

RowsOf<RobotReport> rows(Of<RobotReport>) {
  return header<RobotReport>("robot").with(
      {{"urdf", {{"file", [](auto& r) { return r.robot.file; }}, {"sha256", &RobotReport::sha256}}},
       {"robot", {{"name", [](auto& r) { return r.robot.name; }}, {"roots", &RobotReport::roots}}},
       {"first_spec",
        [](auto& r) {
          return only_if(!r.tip.empty(), FirstSpec{r.base, r.tip});
        },
        "the chain of --write-spec"},
       {"links", [](auto& r) { return r.robot.links; }},
       {"joints", [](auto& r) { return r.robot.joints; }},
       {"couplings", [](auto& r) { return r.robot.couplings; }, "of two motors and two joints"},
       {"ends", within(&RobotReport::ends), "of the tree, the likeliest tip first"},
       {"flaws", [](auto& r) { return r.robot.flaws; }},
       {"pose", &RobotReport::pose, "of --at", optional}});
}

}  // namespace qerr
