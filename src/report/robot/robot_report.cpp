#include "qerr/report/robot_report.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include "core/run_files.hpp"
#include "input/joint_entries.hpp"
#include "input/read_sections.hpp"
#include "input/urdf_reader.hpp"
#include "kinematics/tree.hpp"
#include "qerr/input/first_spec.hpp"
#include "report/formats.hpp"
#include "report/text_table.hpp"

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
      throw Error("--at", "needs a joint and its value", quoted(text), "write --at q1=30deg,q2=0.1");
    const std::size_t index = find_joint(robot, chain, text.substr(0, sign), {}, "--at");
    const IndependentJoint& joint = at.joints[index].first;
    const Dimension dimension = joint.prismatic() ? dimension::length : dimension::angle;
    std::string why;
    const auto value = parse_quantity(text.substr(sign + 1), why);
    if (!value || value->dimension.value_or(dimension) != dimension)
      throw Error("--at", "must be " + name_of(dimension), quoted(text), unit_remedy(dimension));
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
  Eigen::VectorXd q(std::ssize(at.joints));
  for (Eigen::Index i = 0; i < q.size(); ++i) q[i] = at.joints[i].second;
  at.pose = forward_kinematics(chain, q);
  return at;
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

constexpr std::size_t most_ends = 20;
constexpr std::size_t most_flaws = 12;
constexpr std::size_t least_joint = 18;  // columns of the last joint's name

std::string summary(const RobotReport& report) {
  std::map<std::string, std::size_t> types;
  std::size_t moving = 0, mimics = 0;
  for (const Joint& joint : report.robot.joints) {
    if (joint.type == JointType::fixed) continue;
    ++moving;
    ++types[std::string(joint_type_name(joint.type))];
    mimics += joint.mimic.has_value();
  }
  std::vector<std::string> parts;
  for (const auto& [type, count] : types) parts.push_back(std::to_string(count) + ' ' + type);
  return counted(report.robot.links.size(), "link") + ", " + counted(moving, "moving joint") +
         (parts.empty() ? "" : " (" + listed(parts) + (mimics ? "; " + counted(mimics, "mimic") : "") + ")") +
         ", " + counted(report.ends.size(), "end");
}

/// Whether all ends that move have one base, which then needs no column.
bool one_base(const RobotReport& report) {
  const auto moves = [](const TreeEnd& end) { return !end.joints.empty(); };
  const auto first = std::ranges::find_if(report.ends, moves);
  return std::ranges::all_of(report.ends,
                             [&](const TreeEnd& end) { return !moves(end) || end.base == first->base; });
}

/// Ends moved by the same joints are one row: the likeliest tip and the number of the others.
std::string end_text(const RobotReport& report, std::size_t width) {
  TableRows rows{{"tip", "moving joints", "last joint", "base"}};
  std::map<std::vector<std::size_t>, std::size_t> row_of;
  std::map<std::size_t, std::size_t> beside;
  for (const TreeEnd& end : report.ends) {
    if (end.joints.empty()) continue;
    const auto [row, fresh] = row_of.emplace(end.joints, rows.size());
    if (!fresh) {
      ++beside[row->second];
      continue;
    }
    rows.push_back({escaped(end.tip, 4096), std::to_string(end.joints.size()),
                    report.robot.joints[end.joints.back()].name, shortened(end.base, 14)});
  }
  for (const auto& [row, count] : beside) rows[row][0] += " +" + std::to_string(count);
  const std::size_t all = rows.size() - 1;
  if (all == 0) return "";
  if (all > most_ends) rows.resize(1 + most_ends);
  if (one_base(report))
    for (auto& row : rows) row.pop_back();
  // A tip is typed, hence shown whole wherever it fits; the joint has what is left.
  const std::size_t room = width - (one_base(report) ? 2 + 2 + 13 + 2 : 2 + 2 + 13 + 2 + 2 + 14);
  std::size_t widest = 0;
  for (auto& row : rows) {
    row[0] = shortened(row[0], room - least_joint);
    widest = std::max(widest, display_width(row[0]));
  }
  for (auto& row : rows) row[2] = shortened(row[2], room - widest);
  std::string text = aligned(rows);
  if (all > most_ends) text += "  and " + std::to_string(all - most_ends) + " more (--format json has all)\n";
  if (!beside.empty()) text += "  +n: as many more ends that the same joints move\n";
  return text;
}

/// `line 12: joint 'a': RULE, found ...`, folded; flaws of one kind are one entry.
std::string flaw_text(const RobotReport& report, std::size_t width) {
  std::map<std::string, std::size_t> alike;
  for (const Flaw& flaw : report.robot.flaws) ++alike[flaw.fault.rule];
  std::string text;
  std::size_t kinds = 0;
  for (const Flaw& flaw : report.robot.flaws) {
    const std::size_t count = std::exchange(alike[flaw.fault.rule], 0);
    if (count == 0 || ++kinds > most_flaws) continue;
    Fault fault = flaw.fault;
    fault.place.file = "line " + std::to_string(fault.place.line);
    fault.place.line = 0;
    text += wrapped((flaw.spoils ? "error: " : "") + format({fault}) +
                        (count > 1 ? " (and " + std::to_string(count - 1) + " more of this kind" + ")" : ""),
                    width, "    ", "  ", LongWords::cut);
  }
  if (kinds > most_flaws) text += "  and others (--format json has all)\n";
  return text;
}

/// The options that lead to the chain of the report, if it is not that of the first end.
std::string chosen_ends(const RobotReport& report) {
  const TreeEnd& first = report.ends.front();
  return (report.base == first.base ? "" : " --base " + shell_word(escaped(report.base))) +
         (report.tip == first.tip ? "" : " --tip " + shell_word(escaped(report.tip)));
}

std::string next_step(const RobotReport& report, std::size_t width) {
  if (report.tip.empty())
    return wrapped("No chain can be analyzed: " + report.obstacle, width, "  ", "", LongWords::cut);
  const std::string chain =
      "from '" + escaped(report.base) + "' to '" + escaped(report.tip) + "' (--base and --tip choose others)";
  if (report.of_spec) return "  qerr analyze " + shell_word(escaped(report.spec_file)) + '\n';
  if (!report.spec_file.empty())
    return wrapped("The first spec, " + chain + ", is in " + escaped(report.spec_file) +
                       "; fill in what is marked ASSUMED in it, then qerr analyze that file",
                   width, "  ", "", LongWords::cut);
  const std::string& file = report.robot.file;
  const auto command = [&](const std::string& urdf) {
    return "  qerr robot " + urdf + chosen_ends(report) + " --write-spec spec.yaml\n";
  };
  std::string line = command(file == "(standard input)" ? "-" : shell_word(escaped(file)));
  if (display_width(line) > width + 1) line = command("URDF");  // with its line break
  return wrapped("A first spec, " + chain + ":", width, "  ", "", LongWords::cut) + line +
         "  qerr analyze spec.yaml\n";
}

/// The joint values and the tip's pose, without exponents: ten digits tell two conventions apart.
std::string pose_text(const PoseAtJoints& at, const Style& style) {
  const auto decimal = [](double value) {
    const std::string text = fixed_point(value, 10);
    return text == "-0.0000000000" ? text.substr(1) : text;
  };
  std::string values;
  for (const auto& [joint, value] : at.joints)
    values += (values.empty() ? "" : ", ") + shown(joint.name) + " = " +
              (joint.prismatic() ? shortest(value) + " m"
                                 : shortest(std::round(value * 180e9 / std::numbers::pi) / 1e9) + " deg");
  const Eigen::Vector3d rpy = roll_pitch_yaw(at.pose.linear());
  TableRows rows{{"", "x", "y", "z"}, {"position [m]"}, {"roll, pitch, yaw [deg]"}};
  for (Eigen::Index i = 0; i < 3; ++i) {
    rows[1].push_back(decimal(at.pose.translation()[i]));
    rows[2].push_back(decimal(rpy[i] * 180 / std::numbers::pi));
    rows.push_back({std::string("axis ") + "xyz"[i]});
    for (Eigen::Index k = 0; k < 3; ++k) rows.back().push_back(decimal(at.pose.linear()(k, i)));
  }
  return heading("Pose of '" + escaped(at.tip) + "' in '" + escaped(at.base) + "'", style) +
         wrapped("at " + values, std::max<std::size_t>(style.width, 60), "  ", "", LongWords::cut) +
         aligned(rows);
}

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
std::size_t width_beside_names(const TableRows& rows) {
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

/// The moving joints with axis, range, effort, velocity and stated ratio; then the mimics.
std::string joint_text(const RobotReport& report, std::size_t width) {
  TableRows rows{{"joint", "type", "axis", "lower", "upper", "effort", "speed", "ratio"}};
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

constexpr std::size_t longest_name = 30;
constexpr std::size_t deepest_indent = 24;  // branches beyond are not indented further

/// A link with everything that is fixed to it, and the moving joints that leave it.
struct Body {
  std::vector<std::string> links;
  std::vector<std::size_t> joints;
};

Body body_of(const RobotModel& robot, const Tree& tree, const std::string& link) {
  Body body{{link}, {}};
  for (std::size_t i = 0; i < body.links.size(); ++i) {
    const std::string parent = body.links[i];  // links grows
    for (const std::size_t joint : tree.below(parent)) {
      if (robot.joints[joint].type == JointType::fixed)
        body.links.push_back(robot.joints[joint].child);
      else
        body.joints.push_back(joint);
    }
  }
  return body;
}

/// `base_link + camera, imu and 3 more`, as many names as fit.
std::string named(const std::vector<std::string>& links, std::size_t width) {
  const std::size_t for_others = links.size() > 1 ? 6 : 0;  // `+ 12`
  std::string text = shortened(links.front(), std::clamp<std::size_t>(width - for_others, 8, longest_name));
  for (std::size_t i = 1; i < links.size(); ++i) {
    const std::string next = (i == 1 ? " + " : ", ") + shortened(links[i], longest_name);
    const std::string rest = " and " + std::to_string(links.size() - i) + " more";
    const bool last = i + 1 == links.size();
    if (display_width(text) + display_width(next) + (last ? 0 : rest.size()) > width)
      return text + (i == 1 ? " + " + std::to_string(links.size() - 1) : rest);
    text += next;
  }
  return text;
}

/// The tree: a line for each moving joint with the link that it moves and what is fixed to that link.
std::string tree_text(const RobotReport& report, std::size_t width) {
  const RobotModel& robot = report.robot;
  const Tree tree(robot);
  std::string out;
  struct Line {
    std::string indent, mark, joint, link;
  };
  std::vector<Line> open;  // a stack, so that a long chain needs no recursion
  for (auto root = report.roots.rbegin(); root != report.roots.rend(); ++root)
    open.push_back({"  ", "", "", *root});
  while (!open.empty()) {
    const Line line = open.back();
    open.pop_back();
    const Body body = body_of(robot, tree, line.link);
    const std::string begin =
        line.indent + line.mark + (line.joint.empty() ? "" : shortened(line.joint, longest_name) + ": ");
    const std::size_t used = display_width(begin);
    out += begin + named(body.links, width - std::min(used, width - 8)) + '\n';
    std::string below = line.indent;
    if (!line.mark.empty() && display_width(below) < deepest_indent) below += line.mark == "└ " ? "  " : "│ ";
    const bool branches = body.joints.size() > 1;
    for (std::size_t i = body.joints.size(); i-- > 0;) {
      const Joint& joint = robot.joints[body.joints[i]];
      const char* mark = !branches ? "" : i + 1 == body.joints.size() ? "└ " : "├ ";
      open.push_back({below, mark, joint.name.empty() ? "(no name)" : joint.name, joint.child});
    }
  }
  return out;
}

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
             return each(end->joints, [&](std::size_t i) { return end.whole.robot.joints[i].name; });
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
          {"rpy",
           [](auto& at) {
             const Eigen::Vector3d angles = roll_pitch_yaw(at.pose.linear());
             return std::vector<double>(angles.begin(), angles.end());
           },
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

std::string to_table(const RobotReport& report, const Style& style) {
  if (report.pose) return pose_text(*report.pose, style).substr(1);
  constexpr std::size_t least_width = 60;  // narrower tables show no names
  const std::size_t width = std::max(style.width, least_width);
  const std::string name = report.robot.name.empty() ? "(no name)" : shown(report.robot.name);
  std::string out = painted(name, Paint::bold, style) +
                    wrapped(summary(report), width, "  ", name + ": ", LongWords::cut).substr(name.size());
  out +=
      heading("Tree: joint: link that it moves + links fixed to that link", style) + tree_text(report, width);
  if (const std::string joints = joint_text(report, width); !joints.empty())
    out += heading("Moving joints", style) + joints;
  if (const std::string ends = end_text(report, width); !ends.empty())
    out += heading("Ends of the tree, the likeliest tips first", style) + ends;
  if (const std::string flaws = flaw_text(report, width); !flaws.empty())
    out += heading("Flaws of the URDF", style) + flaws;
  return out + '\n' + next_step(report, width);
}

}  // namespace qerr
