#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "qerr/kinematics/robot_model.hpp"

namespace qerr {

/// What the name of a link says about it.
enum class EndKind { tool, other, sensor };

/// An end of the tree: a link without children, which may be the tip of a chain.
struct TreeEnd {
  std::string tip;
  std::string base;                 ///< the root, or the link below the last floating or planar joint
  std::vector<std::size_t> joints;  ///< moving joints between the two, indices of RobotModel::joints
  EndKind kind = EndKind::other;
};

/// The ends below `base` (empty: of the whole robot), the likeliest tips first: sensors and ends that no
/// joint moves stand last; among the others the end with the most moving joints is first, and of ends with
/// equally many the one that is named like a tool (`tool0`, `flange`, `*_tcp`, `*_ee`).
std::vector<TreeEnd> tree_ends(const RobotModel&, const std::string& base = "");

/// The base of a chain to the tip: the link below the last floating or planar joint above it, else the root
/// of its tree; empty if that is the only root.
std::string natural_base(const RobotModel&, const std::string& tip);

std::string_view end_kind_name(EndKind);

}  // namespace qerr
