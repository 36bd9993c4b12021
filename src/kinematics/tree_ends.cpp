#include "qerr/kinematics/tree_ends.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <tuple>

#include "kinematics/tree.hpp"

namespace qerr {

namespace {

/// Words of a link's name, in lower case: `left_Tool0` has the words `left` and `tool0`, `topCamera` the
/// words `top` and `camera`.
std::vector<std::string> words_of_name(const std::string& name) {
  std::vector<std::string> words(1);
  bool after_lower = false;
  for (const char c : name) {
    const auto letter = static_cast<unsigned char>(c);
    const bool separator = std::string_view("_/-. ").find(c) != std::string_view::npos;
    if (separator || (after_lower && std::isupper(letter))) words.emplace_back();
    if (!separator) words.back() += static_cast<char>(std::tolower(letter));
    after_lower = std::islower(letter);
  }
  std::erase(words, "");
  return words;
}

constexpr std::array tools{"tool0", "flange", "tcp", "ee", "tool", "eef", "gripper", "hand"};
constexpr std::array sensors{"camera", "cam",        "optical", "imu",    "laser", "lidar", "sensor",
                             "depth",  "scan",       "sonar",   "kinect", "gyro",  "gps",   "rgb",
                             "ir",     "microphone", "mic",     "accel",  "led",   "stereo"};

/// Position of the first of the words in the list, at most its length; digits at the end do not count.
template <std::size_t N>
std::size_t rank_in(const std::array<const char*, N>& list, const std::vector<std::string>& words) {
  std::size_t best = N;
  for (std::string word : words) {
    const auto rank = [&] {
      return static_cast<std::size_t>(std::find(list.begin(), list.end(), word) - list.begin());
    };
    best = std::min(best, rank());
    word.erase(word.find_last_not_of("0123456789") + 1);
    best = std::min(best, rank());
  }
  return best;
}

/// The end of a path of joints, which starts below its last floating or planar joint.
TreeEnd end_of(const RobotModel& robot, const std::string& tip, const std::string& base,
               const std::vector<std::size_t>& path) {
  TreeEnd end{tip, base, {}, EndKind::other};
  for (const std::size_t i : path) {
    const Joint& joint = robot.joints[i];
    if (joint.type == JointType::floating || joint.type == JointType::planar) {
      end.base = joint.child;
      end.joints.clear();
    } else if (joint.type != JointType::fixed) {
      end.joints.push_back(i);
    }
  }
  const std::vector<std::string> words = words_of_name(tip);
  if (rank_in(sensors, words) < sensors.size())
    end.kind = EndKind::sensor;
  else if (rank_in(tools, words) < tools.size())
    end.kind = EndKind::tool;
  return end;
}

/// Number of joints up to the last tool on the way to an end, whose further joints are those of a gripper;
/// all of them if there is none.
std::size_t joints_to_tool(const TreeEnd& end, const std::vector<TreeEnd>& ends) {
  std::size_t most = 0;
  for (const TreeEnd& tool : ends)
    if (tool.kind == EndKind::tool && tool.joints.size() < end.joints.size() &&
        std::equal(tool.joints.begin(), tool.joints.end(), end.joints.begin()))
      most = std::max(most, tool.joints.size());
  return most > 0 ? most : end.joints.size();
}

/// Sorts ends by what people mean with a tip: the end of the longest chain, at its tool rather than at the
/// fingers beyond, and sensors last.
void sort_ends(std::vector<TreeEnd>& ends) {
  const auto order = [&](const TreeEnd& end) {
    const std::size_t joints = joints_to_tool(end, ends);
    return std::tuple(joints == 0, end.kind == EndKind::sensor, -static_cast<std::ptrdiff_t>(joints),
                      joints < end.joints.size(), rank_in(tools, words_of_name(end.tip)));
  };
  std::vector<std::pair<decltype(order(ends.front())), TreeEnd>> keyed;
  for (const TreeEnd& end : ends) keyed.emplace_back(order(end), end);
  std::stable_sort(keyed.begin(), keyed.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  for (std::size_t i = 0; i < ends.size(); ++i) ends[i] = std::move(keyed[i].second);
}

}  // namespace

std::string_view end_kind_name(EndKind kind) {
  return kind == EndKind::tool ? "tool" : kind == EndKind::sensor ? "sensor" : "other";
}

std::string natural_base(const RobotModel& robot, const std::string& tip) {
  const Tree tree(robot);
  const std::vector<std::size_t> path = tree.path_to(tip);
  const std::string root = path.empty() ? tip : robot.joints[path.front()].parent;
  const std::string base = end_of(robot, tip, root, path).base;
  for (const Flaw& flaw : robot.flaws)
    if (flaw.below_missing_joint == base) throw Error(flaw.fault);
  return base;
}

std::vector<TreeEnd> tree_ends(const RobotModel& robot, const std::string& base) {
  const Tree tree(robot);
  std::vector<TreeEnd> ends;
  for (const std::string& link : robot.links) {
    if (!tree.below(link).empty()) continue;
    std::vector<std::size_t> path = tree.path_to(link);
    const auto from = std::find_if(path.begin(), path.end(),
                                   [&](std::size_t joint) { return robot.joints[joint].parent == base; });
    if (!base.empty() && from == path.end() && link != base) continue;
    if (!base.empty()) path.erase(path.begin(), from);
    const std::string root = path.empty() ? link : robot.joints[path.front()].parent;
    ends.push_back(end_of(robot, link, root, path));
  }
  sort_ends(ends);
  return ends;
}

}  // namespace qerr
