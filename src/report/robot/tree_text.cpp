#include <algorithm>
#include <functional>

#include "kinematics/tree.hpp"
#include "report/robot/parts.hpp"

namespace qerr {

namespace {

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

}  // namespace

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

}  // namespace qerr
