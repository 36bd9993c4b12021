#include "qerr/kinematics/chain.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>
#include <unordered_map>

#include "core/text.hpp"
#include "kinematics/tree.hpp"

namespace qerr {

namespace {

constexpr std::size_t most_unused_flaws = 3;  // a few say what kind of file it is; `qerr robot` has all

class Builder {
 public:
  explicit Builder(const RobotModel& robot) : robot_(robot), by_name_(joints_by_name(robot)) {}

  /// Appends the next joint of the path. One that leads from child to parent has the inverse motion, which
  /// turns about the reversed axis, and its origin behind it.
  void add(std::size_t index, bool upward) {
    const Joint& joint = robot_.joints[index];
    if (joint.type == JointType::floating || joint.type == JointType::planar)
      throw Error(joint.place, "joint '" + joint.name + "'",
                  "a joint between base and tip must be revolute, continuous, prismatic or fixed",
                  joint.type == JointType::floating ? "a floating joint" : "a planar joint",
                  "choose robot.base and robot.tip so that it is not between them");
    const Eigen::Matrix3d parent_axes =
        upward ? Eigen::Matrix3d(joint.origin.linear().transpose()) : pending_.linear();
    if (!upward) pending_ = pending_ * joint.origin;
    if (joint.type != JointType::fixed) add_moving(index, parent_axes, upward);
    if (upward) pending_ = pending_ * joint.origin.inverse();
  }

  Chain finish(std::string base, std::string tip) {
    chain_.base = std::move(base);
    chain_.tip = std::move(tip);
    chain_.tip_offset = pending_;
    return std::move(chain_);
  }

 private:
  void add_moving(std::size_t index, const Eigen::Matrix3d& parent_axes, bool upward) {
    const Joint& joint = robot_.joints[index];
    const Drive drive = drive_of(robot_, by_name_, index);
    const Joint& master = robot_.joints[drive.master];
    auto found = std::ranges::find_if(chain_.independent,
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
                             upward ? -joint.axis : joint.axis,
                             static_cast<std::size_t>(found - chain_.independent.begin()),
                             drive.multiplier,
                             drive.offset,
                             {},
                             parent_axes,
                             upward});
    pending_ = Eigen::Isometry3d::Identity();
  }

  const RobotModel& robot_;
  JointIndex by_name_;
  Chain chain_;
  Eigen::Isometry3d pending_ = Eigen::Isometry3d::Identity();
};

/// Sums the inertias of a link and of everything that is connected to it without a moving joint of the chain.
/// Joints beside the chain are at zero.
class LoadSum {
 public:
  LoadSum(const RobotModel& robot, const std::vector<std::size_t>& path) : robot_(robot) {
    for (std::size_t i = 0; i < robot.links.size(); ++i) link_[robot.links[i]] = i;
    for (std::size_t i = 0; i < robot.joints.size(); ++i)
      for (const std::string& end : {robot.joints[i].parent, robot.joints[i].child})
        joints_at_[end].push_back(i);
    for (const std::size_t joint : path)
      if (robot.joints[joint].type != JointType::fixed) passed_.insert(joint);
  }

  /// @param pose  of the link, in the frame of the load
  void add(const std::string& link, const Eigen::Isometry3d& pose, Inertia& load) {
    std::vector<std::pair<std::string, Eigen::Isometry3d>> open{{link, pose}};
    std::set<std::size_t> passed = passed_;
    while (!open.empty()) {
      const auto [name, link_pose] = open.back();
      open.pop_back();
      if (const std::size_t i = link_.at(name); i < robot_.inertias.size())
        load = sum(load, moved(robot_.inertias[i], link_pose));
      for (const std::size_t index : joints_at_[name]) {
        if (!passed.insert(index).second) continue;
        const Joint& joint = robot_.joints[index];
        if (joint.parent == name)
          open.emplace_back(joint.child, link_pose * joint.origin);
        else
          open.emplace_back(joint.parent, link_pose * joint.origin.inverse());
      }
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
  JointIndex link_;
  std::unordered_map<std::string, std::vector<std::size_t>> joints_at_;
  std::set<std::size_t> passed_;
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
  std::ranges::sort(order, [&](std::size_t a, std::size_t b) { return place[a] < place[b]; });
  std::vector<std::size_t> new_index(order.size());
  std::vector<IndependentJoint> sorted;
  for (std::size_t i = 0; i < order.size(); ++i) {
    new_index[order[i]] = i;
    sorted.push_back(chain.independent[order[i]]);
  }
  chain.independent = std::move(sorted);
  for (ChainJoint& joint : chain.joints) joint.coordinate = new_index[joint.coordinate];
}

/// Gives the chains the independent joints of all of them.
void share_joints(std::vector<NamedTip>& tips) {
  std::vector<IndependentJoint> all;
  for (NamedTip& tip : tips) {
    std::vector<std::size_t> place;  // of the chain's joints, in `all`
    for (const IndependentJoint& joint : tip.chain.independent) {
      const auto found =
          std::ranges::find_if(all, [&](const IndependentJoint& other) { return other.name == joint.name; });
      place.push_back(static_cast<std::size_t>(found - all.begin()));
      if (found == all.end())
        all.push_back(joint);
      else
        found->on_chain = found->on_chain || joint.on_chain;
    }
    for (ChainJoint& joint : tip.chain.joints) joint.coordinate = place[joint.coordinate];
  }
  for (NamedTip& tip : tips) tip.chain.independent = all;
}

/// Whether a joint moves one link against the other.
bool moves(const RobotModel& robot, const std::string& base, const std::string& tip) {
  const TreePath path = find_path(robot, base, tip);
  return std::ranges::any_of(path.joints,
                             [&](std::size_t i) { return robot.joints[i].type != JointType::fixed; });
}

}  // namespace

Chain make_chain(const RobotModel& robot, const std::string& base, const std::string& tip) {
  const TreePath path = find_path(robot, base, tip);
  Builder builder(robot);
  for (std::size_t i = 0; i < path.joints.size(); ++i) builder.add(path.joints[i], i < path.upward);
  Chain chain = builder.finish(path.base, path.tip);
  if (chain.joints.empty())
    throw Error({robot.file, 0, 0}, "robot.tip", "no moving joint between base and tip",
                "base '" + path.base + "', tip '" + path.tip + "'",
                "choose links with a moving joint between them");
  LoadSum loads(robot, path.joints);
  auto moving = chain.joints.begin();
  for (std::size_t i = 0; i < path.joints.size(); ++i) {
    const Joint& joint = robot.joints[path.joints[i]];
    if (joint.type == JointType::fixed) continue;
    if (i < path.upward)
      loads.add(joint.parent, joint.origin.inverse(), (moving++)->load);
    else
      loads.add(joint.child, Eigen::Isometry3d::Identity(), (moving++)->load);
  }
  sort_along_chain(chain);
  return chain;
}

std::vector<NamedTip> make_chains(const RobotModel& robot, const std::string& base,
                                  const std::vector<std::pair<std::string, std::string>>& tips) {
  std::vector<NamedTip> all;
  for (const auto& [name, link] : tips) {
    try {
      all.push_back({name, make_chain(robot, base, link)});
    } catch (const Error& e) {
      std::vector<Fault> faults = e.faults();
      for (Fault& fault : faults)
        if (fault.key == "robot.tip") fault.key = "robot.tips." + name;
      throw Error(faults, e.trouble());
    }
  }
  for (const auto& [name, link] : tips)
    for (const auto& [other, from] : tips)
      if (name != other && moves(robot, from, link))
        all.push_back({name + '-' + other, make_chain(robot, from, link)});
  share_joints(all);
  return all;
}

std::vector<std::string> warnings_about(const RobotModel& robot, const Chain& chain) {
  return warnings_about(robot, {&chain});
}

std::vector<std::string> warnings_about(const RobotModel& robot, const std::vector<const Chain*>& chains) {
  std::vector<TreePath> paths;
  std::vector<UsedParts> used;
  for (const Chain* chain : chains) {
    paths.push_back(find_path(robot, chain->base, chain->tip));
    used.emplace_back(robot, paths.back());
  }
  const std::string these = chains.size() > 1 ? "these chains" : "this chain";
  std::vector<std::string> warnings;
  std::map<std::string, std::size_t> place_of_rule;  // in `warnings`
  std::vector<std::size_t> alike;
  std::size_t unused = 0;
  for (const Flaw& flaw : robot.flaws) {
    const bool concerns =
        std::ranges::any_of(used, [&](const UsedParts& u) { return u.concerned_by(flaw); }) ||
        (!flaw.spoils && flaw.joints.empty() && flaw.link.empty());
    if (!concerns && ++unused > most_unused_flaws) continue;
    const auto [first, fresh] = place_of_rule.emplace(flaw.fault.rule, warnings.size());
    if (!fresh) {
      ++alike[first->second];
      continue;
    }
    warnings.push_back(format({flaw.fault}) + (concerns ? "" : " (not used by " + these + ")"));
    alike.push_back(0);
  }
  for (std::size_t i = 0; i < warnings.size(); ++i)
    if (alike[i] > 0) warnings[i] += " (and the same " + counted(alike[i], "more time") + ")";
  if (unused > most_unused_flaws)
    warnings.push_back(counted(unused - most_unused_flaws, "more flaw") + " of the URDF outside " + these +
                       "; qerr robot lists them");
  const auto has_mass = [](const ChainJoint& joint) { return joint.load.mass > 0; };
  for (std::size_t i = 0; i < chains.size(); ++i)
    if (paths[i].upward > 0 && std::ranges::any_of(chains[i]->joints, has_mass)) {
      warnings.push_back(
          "robot.base: '" + chains[i]->base +
          "' is not above the tip: gravity and inertias are those of a robot that is held there");
      break;
    }
  return warnings;
}

std::size_t independent_index(const Chain& chain, std::string_view name) {
  const auto& joints = chain.independent;
  const auto found = std::ranges::find_if(joints, [&](const IndependentJoint& j) { return j.name == name; });
  if (found == joints.end()) throw std::out_of_range("no independent joint '" + std::string(name) + "'");
  return found - joints.begin();
}

std::optional<std::size_t> find_joint(const Chain& chain, std::string_view name) {
  const auto& joints = chain.joints;
  const auto found = std::ranges::find_if(joints, [&](const ChainJoint& j) { return j.name == name; });
  if (found == joints.end()) return std::nullopt;
  return found - joints.begin();
}

OriginPlace origin_place(const Chain& chain, std::size_t joint) {
  const ChainJoint& j = chain.joints.at(joint);
  return j.upward ? OriginPlace{joint + 1, -j.parent_axes} : OriginPlace{joint, j.parent_axes};
}

Eigen::Isometry3d forward_kinematics(const Chain& chain, const Eigen::VectorXd& q) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  for (const ChainJoint& joint : chain.joints) {
    const double motion = joint.multiplier * q[joint.coordinate] + joint.offset;
    pose = pose * joint.origin;
    if (joint.prismatic)
      pose.translate(motion * joint.axis);
    else
      pose.rotate(Eigen::AngleAxisd(motion, joint.axis));
  }
  return pose * chain.tip_offset;
}

Eigen::Isometry3d tracked_tip(const Chain& chain, const Eigen::VectorXd& q) {
  return chain.tracker * forward_kinematics(chain, q);
}

}  // namespace qerr
