#pragma once

#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "qerr/kinematics/robot_model.hpp"

namespace qerr {

/// The links and joints of a robot as a tree; several trees if the URDF has several roots. Borrows the model,
/// which must outlive it.
class Tree {
 public:
  explicit Tree(const RobotModel& robot);
  Tree(RobotModel&&) = delete;

  const std::vector<std::string>& roots() const { return roots_; }  ///< in file order
  /// Joints whose parent is the link, in file order.
  const std::vector<std::size_t>& below(const std::string& link) const;
  /// Joints from the root of its tree down to the link.
  std::vector<std::size_t> path_to(const std::string& link) const;

 private:
  const RobotModel& robot_;
  std::vector<std::string> roots_;
  std::unordered_map<std::string, std::size_t> above_;  ///< child link -> its joint
  std::unordered_map<std::string, std::vector<std::size_t>> below_;
};

/// Joints from `base` through the common ancestor to `tip`, nearest to the base first. A flaw that spoils a
/// part of this chain is an error; any other is not.
/// @param base  empty: the root
/// @param tip   empty: the only leaf
/// @throws Error (input; keys `robot.base`, `robot.tip`)
struct TreePath {
  std::string base, tip;
  std::vector<std::size_t> joints;
  std::size_t upward = 0;  ///< joints at the beginning that lead from child to parent
};
TreePath find_path(const RobotModel&, const std::string& base, const std::string& tip);

/// The independent joint that moves a joint through all mimics, with the composed multiplier and offset.
struct Drive {
  std::size_t master;
  double multiplier = 1, offset = 0;
};
using JointIndex = std::unordered_map<std::string, std::size_t>;
JointIndex joints_by_name(const RobotModel&);
Drive drive_of(const RobotModel&, const JointIndex& by_name, std::size_t joint);

/// Whether the chain uses a part that the flaw concerns: a joint of the path or a master of one, or a link.
class UsedParts {
 public:
  UsedParts(const RobotModel&, const TreePath&);
  bool concerned_by(const Flaw&) const;

 private:
  std::unordered_set<std::string> joints_, links_;
};

}  // namespace qerr
