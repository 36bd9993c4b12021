#pragma once

#include <Eigen/Core>
#include <vector>

#include "control/loop.hpp"
#include "qerr/bound/operational_error.hpp"

namespace qerr {

/// A joint's loop over the configurations: the least margins and bandwidth, the largest limit cycle.
struct WorstLoop {
  std::size_t joint = 0;
  double least_inertia = 0, largest_inertia = 0;  ///< [kg m^2 or kg]
  bool stable = false;                            ///< at all inertias
  double unstable_inertia = 0;                    ///< of an unstable loop: one at which it is
  LoopMargins margins;                            ///< least; of an unstable loop at that inertia
  LimitCycle cycle;                               ///< largest; of a stable loop
};

/// The loops of some joints, each at the worst of its inertias at the configurations: the l1 norms are
/// certified where they are largest. Joints with one loop share its evaluation.
/// @param joints  whose inertia is known
/// @param configurations  joints x configurations
std::vector<WorstLoop> worst_loops(const OperationalModel&, const std::vector<std::size_t>& joints,
                                   const Eigen::MatrixXd& configurations);

}  // namespace qerr
