#include <algorithm>
#include <map>
#include <utility>

#include "input/urdf_reader.hpp"
#include "report/formats.hpp"
#include "report/robot/parts.hpp"

namespace qerr {

namespace {

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
  const auto first = std::find_if(report.ends.begin(), report.ends.end(), moves);
  return std::all_of(report.ends.begin(), report.ends.end(),
                     [&](const TreeEnd& end) { return !moves(end) || end.base == first->base; });
}

/// Ends moved by the same joints are one row: the likeliest tip and the number of the others.
std::string end_text(const RobotReport& report, std::size_t width) {
  std::vector<std::vector<std::string>> rows{{"tip", "moving joints", "last joint", "base"}};
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

/// What to type next.
std::string next_step(const RobotReport& report, std::size_t width) {
  if (report.tip.empty())
    return wrapped("No chain can be analyzed: " + report.obstacle, width, "  ", "", LongWords::cut);
  const std::string chain =
      "from '" + escaped(report.base) + "' to '" + escaped(report.tip) + "' (--base and --tip choose others)";
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

}  // namespace

std::string to_table(const RobotReport& report, const Style& style) {
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
