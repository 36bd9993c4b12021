#include "kinematics/tree.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <tuple>

#include "core/lists.hpp"
#include "core/text.hpp"

namespace qerr {

namespace {

Fault robot_fault(const RobotModel& robot, std::string key, std::string rule, std::string found,
                  std::string remedy) {
  return {{robot.file, 0, 0}, std::move(key), std::move(rule), std::move(found), std::move(remedy)};
}

/// The flaws that spoil a part for which `concerns` holds.
template <class Predicate>
std::vector<Fault> spoiling(const RobotModel& robot, Predicate concerns) {
  std::vector<Fault> faults;
  for (const Flaw& flaw : robot.flaws)
    if (flaw.spoils && concerns(flaw)) faults.push_back(flaw.fault);
  return faults;
}

constexpr auto any = [](const Flaw&) { return true; };

void raise(const std::vector<Fault>& faults) {
  if (!faults.empty()) throw Error(faults);
}

/// The root, which must be the only one. No flaw may leave open what belongs above it or beside it.
std::string default_base(const RobotModel& robot, const Tree& tree) {
  if (tree.roots().size() != 1) raise(spoiling(robot, any));
  const std::string& root = tree.roots().front();
  raise(spoiling(robot, [&](const Flaw& flaw) {
    return flaw.below_missing_joint == root || (flaw.joints.empty() && flaw.link.empty());
  }));
  return root;
}

std::string default_tip(const RobotModel& robot, const std::string& base) {
  const std::vector<TreeEnd> ends = tree_ends(robot, base);
  if (ends.size() == 1) return ends.front().tip;
  std::string names;
  for (std::size_t i = 0; i < std::min<std::size_t>(ends.size(), 6); ++i)
    names += (i ? ", '" : "'") + ends[i].tip + "' (" +
             (i ? std::to_string(ends[i].joints.size()) : counted(ends[i].joints.size(), "moving joint")) +
             ")";
  std::vector<Fault> faults{robot_fault(robot, "robot.tip",
                                        "the tip must be named when the tree has several leaves",
                                        std::to_string(ends.size()) + " leaves",
                                        "set robot.tip to a link, such as one of " + names +
                                            (ends.size() > 6 ? ", ...; qerr robot lists all" : ""))};
  for (const Fault& fault : spoiling(robot, any)) faults.push_back(fault);
  throw Error(faults);
}

void require_link(const RobotModel& robot, const std::string& key, const std::string& link) {
  if (contains(robot.links, link)) return;
  throw Error(robot_fault(robot, key, "no link of the URDF has this name", "'" + link + "'",
                          did_you_mean(link, robot.links)));
}

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
    const auto rank = [&] { return static_cast<std::size_t>(std::ranges::find(list, word) - list.begin()); };
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
  std::ranges::stable_sort(keyed, [](const auto& a, const auto& b) { return a.first < b.first; });
  for (std::size_t i = 0; i < ends.size(); ++i) ends[i] = std::move(keyed[i].second);
}

}  // namespace

Tree::Tree(const RobotModel& robot) : robot_(robot) {
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    above_[robot.joints[i].child] = i;
    below_[robot.joints[i].parent].push_back(i);
  }
  for (const std::string& link : robot.links)
    if (!above_.contains(link)) roots_.push_back(link);
}

const std::vector<std::size_t>& Tree::below(const std::string& link) const {
  static const std::vector<std::size_t> none;
  const auto found = below_.find(link);
  return found == below_.end() ? none : found->second;
}

std::vector<std::size_t> Tree::path_to(const std::string& link) const {
  std::vector<std::size_t> path;
  for (auto up = above_.find(link); up != above_.end(); up = above_.find(robot_.joints[up->second].parent))
    path.push_back(up->second);
  std::ranges::reverse(path);
  return path;
}

JointIndex joints_by_name(const RobotModel& robot) {
  JointIndex by_name;
  for (std::size_t i = 0; i < robot.joints.size(); ++i) by_name.emplace(robot.joints[i].name, i);
  return by_name;
}

Drive drive_of(const RobotModel& robot, const JointIndex& by_name, std::size_t joint) {
  Drive drive{joint};
  while (robot.joints[drive.master].mimic) {
    const Mimic& mimic = *robot.joints[drive.master].mimic;
    drive.offset += drive.multiplier * mimic.offset;
    drive.multiplier *= mimic.multiplier;
    drive.master = by_name.at(mimic.joint);
  }
  return drive;
}

UsedParts::UsedParts(const RobotModel& robot, const TreePath& path) : links_{path.base} {
  const JointIndex by_name = joints_by_name(robot);
  for (const std::size_t on_path : path.joints) {
    links_.insert(robot.joints[on_path].parent);
    links_.insert(robot.joints[on_path].child);
    for (std::size_t joint = on_path; joints_.insert(robot.joints[joint].name).second;) {
      if (!robot.joints[joint].mimic) break;
      joint = by_name.at(robot.joints[joint].mimic->joint);
    }
  }
}

bool UsedParts::concerned_by(const Flaw& flaw) const {
  return (!flaw.link.empty() && links_.contains(flaw.link)) ||
         std::ranges::any_of(flaw.joints, [&](const std::string& joint) { return joints_.contains(joint); });
}

TreePath find_path(const RobotModel& robot, const std::string& base, const std::string& tip) {
  const Tree tree(robot);
  if (!tip.empty()) require_link(robot, "robot.tip", tip);
  if (!base.empty()) require_link(robot, "robot.base", base);
  TreePath path;
  path.base = base.empty() ? default_base(robot, tree) : base;
  path.tip = tip.empty() ? default_tip(robot, path.base) : tip;
  const std::vector<std::size_t> up = tree.path_to(path.base), down = tree.path_to(path.tip);
  const auto root = [&](const std::vector<std::size_t>& joints, const std::string& link) {
    return joints.empty() ? link : robot.joints[joints.front()].parent;
  };
  if (root(up, path.base) != root(down, path.tip)) {
    raise(spoiling(robot, any));  // one may have cut the tree between the two
    throw Error(robot_fault(robot, "robot.tip", "no joints connect tip and base",
                            "tip '" + path.tip + "', base '" + path.base + "'",
                            "choose two links below one root; qerr robot shows the trees"));
  }
  const auto [ancestor, below] = std::mismatch(up.begin(), up.end(), down.begin(), down.end());
  path.joints.assign(up.rbegin(), std::make_reverse_iterator(ancestor));
  path.upward = path.joints.size();
  path.joints.insert(path.joints.end(), below, down.end());
  const UsedParts used(robot, path);
  raise(spoiling(robot, [&](const Flaw& flaw) { return used.concerned_by(flaw); }));
  return path;
}

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
    const auto from =
        std::ranges::find_if(path, [&](std::size_t joint) { return robot.joints[joint].parent == base; });
    if (!base.empty() && from == path.end() && link != base) continue;
    if (!base.empty()) path.erase(path.begin(), from);
    const std::string root = path.empty() ? link : robot.joints[path.front()].parent;
    ends.push_back(end_of(robot, link, root, path));
  }
  sort_ends(ends);
  return ends;
}

}  // namespace qerr
