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

auto order(const TreeEnd& end) {
  const bool moves = !end.joints.empty();
  return std::tuple(!moves, end.kind == EndKind::sensor, -static_cast<std::ptrdiff_t>(end.joints.size()),
                    rank_in(tools, words_of_name(end.tip)));
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
  std::stable_sort(ends.begin(), ends.end(),
                   [](const TreeEnd& a, const TreeEnd& b) { return order(a) < order(b); });
  return ends;
}

}  // namespace qerr
