#include "qerr/kinematics/chain.hpp"

#include <algorithm>
#include <set>
#include <stdexcept>
#include <unordered_map>

#include "core/suggest.hpp"

namespace qerr {

namespace {

using Index = std::unordered_map<std::string, std::size_t>;

Fault robot_fault(const RobotModel& robot, std::string key, std::string rule, std::string found,
                  std::string remedy) {
  return {{robot.file, 0, 0}, std::move(key), std::move(rule), std::move(found), std::move(remedy)};
}

/// Index of the joint whose child is the link.
Index parent_joints(const RobotModel& robot) {
  Index above;
  for (std::size_t i = 0; i < robot.joints.size(); ++i) above[robot.joints[i].child] = i;
  return above;
}

std::string root_of(const RobotModel& robot, const Index& above) {
  for (const std::string& link : robot.links)
    if (!above.contains(link)) return link;
  return {};
}

std::string only_leaf(const RobotModel& robot) {
  Index is_parent;
  for (const Joint& joint : robot.joints) is_parent[joint.parent] = 1;
  std::vector<std::string> leaves;
  for (const std::string& link : robot.links)
    if (!is_parent.contains(link)) leaves.push_back(link);
  if (leaves.size() == 1) return leaves.front();
  std::string names;
  for (std::size_t i = 0; i < std::min<std::size_t>(leaves.size(), 6); ++i)
    names += (i ? ", '" : "'") + leaves[i] + "'";
  if (leaves.size() > 6) names += ", ...";
  throw Error(robot_fault(robot, "robot.tip", "the tip must be named when the tree has several leaves",
                          std::to_string(leaves.size()) + " leaves",
                          "set robot.tip to a link, such as one of " + names));
}

void require_link(const RobotModel& robot, const std::string& key, const std::string& link) {
  if (std::find(robot.links.begin(), robot.links.end(), link) == robot.links.end())
    throw Error(robot_fault(robot, key, "no link of the URDF has this name", "'" + link + "'",
                            did_you_mean(link, robot.links)));
}

/// Joints from `base` down to `tip`, nearest to the base first.
std::vector<std::size_t> path_down(const RobotModel& robot, const Index& above, const std::string& base,
                                   const std::string& tip) {
  std::vector<std::size_t> path;
  for (std::string link = tip; link != base; link = robot.joints[path.back()].parent) {
    const auto joint = above.find(link);
    if (joint == above.end())
      throw Error(robot_fault(robot, "robot.tip", "the tip must be a descendant of base",
                              "tip '" + tip + "', base '" + base + "'",
                              "choose a base between the root '" + link + "' and the tip"));
    path.push_back(joint->second);
  }
  std::reverse(path.begin(), path.end());
  return path;
}

/// The independent joint that moves a joint through all mimics, with the composed multiplier and offset.
struct Drive {
  std::size_t master;
  double multiplier = 1, offset = 0;
};

Drive drive_of(const RobotModel& robot, const Index& by_name, std::size_t joint) {
  Drive drive{joint};
  while (robot.joints[drive.master].mimic) {
    const Mimic& mimic = *robot.joints[drive.master].mimic;
    drive.offset += drive.multiplier * mimic.offset;
    drive.multiplier *= mimic.multiplier;
    drive.master = by_name.at(mimic.joint);
  }
  return drive;
}

class Builder {
 public:
  explicit Builder(const RobotModel& robot) : robot_(robot) {
    for (std::size_t i = 0; i < robot.joints.size(); ++i) by_name_[robot.joints[i].name] = i;
  }

  /// Appends the next joint of the path.
  void add(std::size_t index) {
    const Joint& joint = robot_.joints[index];
    if (joint.type == JointType::floating || joint.type == JointType::planar)
      throw Error(Fault{joint.place, "joint '" + joint.name + "'",
                        "a joint between base and tip must be revolute, continuous, prismatic or fixed",
                        joint.type == JointType::floating ? "a floating joint" : "a planar joint",
                        "choose robot.base and robot.tip so that it is not between them"});
    const Eigen::Matrix3d parent_axes = pending_.linear();
    pending_ = pending_ * joint.origin;
    if (joint.type != JointType::fixed) add_moving(index, parent_axes);
  }

  Chain finish(std::string base, std::string tip) {
    chain_.base = std::move(base);
    chain_.tip = std::move(tip);
    chain_.tip_offset = pending_;
    return std::move(chain_);
  }

 private:
  void add_moving(std::size_t index, const Eigen::Matrix3d& parent_axes) {
    const Joint& joint = robot_.joints[index];
    const Drive drive = drive_of(robot_, by_name_, index);
    const Joint& master = robot_.joints[drive.master];
    auto found = std::find_if(chain_.independent.begin(), chain_.independent.end(),
                              [&](const IndependentJoint& j) { return j.name == master.name; });
    if (found == chain_.independent.end()) {
      chain_.independent.push_back({master.name, master.type, master.limits, drive.master == index,
                                    master.velocity_limit, master.effort_limit});
      found = std::prev(chain_.independent.end());
    }
    if (drive.master == index) found->on_chain = true;
    chain_.joints.push_back({joint.name,
                             joint.type == JointType::prismatic,
                             pending_,
                             joint.axis,
                             static_cast<std::size_t>(found - chain_.independent.begin()),
                             drive.multiplier,
                             drive.offset,
                             {},
                             parent_axes});
    pending_ = Eigen::Isometry3d::Identity();
  }

  const RobotModel& robot_;
  Index by_name_;
  Chain chain_;
  Eigen::Isometry3d pending_ = Eigen::Isometry3d::Identity();
};

/// Sums the inertias of a link and of everything below it up to the next moving joint of the chain. Joints
/// beside the chain are at zero.
class LoadSum {
 public:
  LoadSum(const RobotModel& robot, const std::vector<std::size_t>& path) : robot_(robot) {
    for (std::size_t i = 0; i < robot.links.size(); ++i) link_[robot.links[i]] = i;
    for (std::size_t i = 0; i < robot.joints.size(); ++i) below_[robot.joints[i].parent].push_back(i);
    for (const std::size_t joint : path)
      if (robot.joints[joint].type != JointType::fixed) on_path_.insert(joint);
  }

  void add(const std::string& link, const Eigen::Isometry3d& pose, Inertia& load) const {
    std::vector<std::pair<std::string, Eigen::Isometry3d>> open{{link, pose}};
    while (!open.empty()) {
      const auto [name, link_pose] = open.back();
      open.pop_back();
      if (const std::size_t i = link_.at(name); i < robot_.inertias.size())
        load = sum(load, moved(robot_.inertias[i], link_pose));
      const auto joints = below_.find(name);
      if (joints == below_.end()) continue;
      for (const std::size_t joint : joints->second)
        if (!on_path_.contains(joint))
          open.emplace_back(robot_.joints[joint].child, link_pose * robot_.joints[joint].origin);
    }
  }

 private:
  static Inertia moved(const Inertia& i, const Eigen::Isometry3d& pose) {
    return {i.mass, pose * i.center, pose.linear() * i.about_center * pose.linear().transpose()};
  }

  /// Inertia of a point mass (parallel axis theorem).
  static Eigen::Matrix3d point_inertia(double mass, const Eigen::Vector3d& r) {
    return mass * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
  }

  static Inertia sum(const Inertia& a, const Inertia& b) {
    const double mass = a.mass + b.mass;
    if (mass == 0) return {0, Eigen::Vector3d::Zero(), a.about_center + b.about_center};
    const Eigen::Vector3d center = (a.mass * a.center + b.mass * b.center) / mass;
    return {mass, center,
            a.about_center + b.about_center + point_inertia(a.mass, a.center - center) +
                point_inertia(b.mass, b.center - center)};
  }

  const RobotModel& robot_;
  Index link_;
  std::unordered_map<std::string, std::vector<std::size_t>> below_;
  std::set<std::size_t> on_path_;
};

/// Sorts the independent joints along the chain. A master that follows its mimic keeps its own place.
void sort_along_chain(Chain& chain) {
  std::vector<std::size_t> place(chain.independent.size(), chain.joints.size());
  for (std::size_t k = chain.joints.size(); k-- > 0;) {
    const ChainJoint& joint = chain.joints[k];
    const IndependentJoint& master = chain.independent[joint.coordinate];
    if (!master.on_chain || joint.name == master.name) place[joint.coordinate] = k;
  }
  std::vector<std::size_t> order(place.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return place[a] < place[b]; });
  std::vector<std::size_t> new_index(order.size());
  std::vector<IndependentJoint> sorted;
  for (std::size_t i = 0; i < order.size(); ++i) {
    new_index[order[i]] = i;
    sorted.push_back(chain.independent[order[i]]);
  }
  chain.independent = std::move(sorted);
  for (ChainJoint& joint : chain.joints) joint.coordinate = new_index[joint.coordinate];
}

}  // namespace

Chain make_chain(const RobotModel& robot, const std::string& base, const std::string& tip) {
  const Index above = parent_joints(robot);
  if (!base.empty()) require_link(robot, "robot.base", base);
  if (!tip.empty()) require_link(robot, "robot.tip", tip);
  const std::string from = base.empty() ? root_of(robot, above) : base;
  const std::string to = tip.empty() ? only_leaf(robot) : tip;

  Builder builder(robot);
  const std::vector<std::size_t> path = path_down(robot, above, from, to);
  for (const std::size_t joint : path) builder.add(joint);
  Chain chain = builder.finish(from, to);
  if (chain.joints.empty())
    throw Error(robot_fault(robot, "robot.tip", "no moving joint between base and tip",
                            "base '" + from + "', tip '" + to + "'",
                            "choose links with a moving joint between them"));
  const LoadSum loads(robot, path);
  auto moving = chain.joints.begin();
  for (const std::size_t joint : path)
    if (robot.joints[joint].type != JointType::fixed)
      loads.add(robot.joints[joint].child, Eigen::Isometry3d::Identity(), (moving++)->load);
  sort_along_chain(chain);
  return chain;
}

std::size_t independent_index(const Chain& chain, std::string_view name) {
  const auto& joints = chain.independent;
  const auto found =
      std::find_if(joints.begin(), joints.end(), [&](const IndependentJoint& j) { return j.name == name; });
  if (found == joints.end()) throw std::out_of_range("no independent joint '" + std::string(name) + "'");
  return static_cast<std::size_t>(found - joints.begin());
}

std::optional<std::size_t> find_joint(const Chain& chain, std::string_view name) {
  const auto& joints = chain.joints;
  const auto found =
      std::find_if(joints.begin(), joints.end(), [&](const ChainJoint& j) { return j.name == name; });
  if (found == joints.end()) return std::nullopt;
  return static_cast<std::size_t>(found - joints.begin());
}

Eigen::Isometry3d forward_kinematics(const Chain& chain, const Eigen::VectorXd& q) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  for (const ChainJoint& joint : chain.joints) {
    const double motion = joint.multiplier * q[static_cast<Eigen::Index>(joint.coordinate)] + joint.offset;
    pose = pose * joint.origin;
    if (joint.prismatic)
      pose.translate(motion * joint.axis);
    else
      pose.rotate(Eigen::AngleAxisd(motion, joint.axis));
  }
  return pose * chain.tip_offset;
}

}  // namespace qerr
