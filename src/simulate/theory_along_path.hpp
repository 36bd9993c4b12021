#pragma once

#include <vector>

#include "qerr/bound/derivative_error.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/simulate/simulate.hpp"

namespace qerr {

/// Largest bounds over the samples of a motion, those of the settling included, since a filter has a memory.
struct BoundsAlongPath {
  Eigen::VectorXd rigorous;  ///< of the position error
  /// Of its difference from the mean error at the centre. A filter multiplies the mean by |H(1)| and the
  /// bound of the difference by its l1 norm.
  Eigen::VectorXd deviation;

  void include(const BoundsAlongPath&);
};

/// Theory of one coordinate after one filter; the members are those of `SimulatedSignal`.
struct SignalTheory {
  double ipqn = 0, ipqn_path = 0, worst_case = 0, worst_case_path = 0;
};

/// Theory of all signals but sigma_exact.
/// @param middle   error at the centre of the motion
/// @param squares  [coordinate]: mean of sum (J C Delta)^2 over the path
/// @returns [0: the position itself, then the filters][coordinate]
std::vector<std::vector<SignalTheory>> theory_along_path(const OperationalError& middle,
                                                         const std::vector<Norms>&,
                                                         const Eigen::VectorXd& squares,
                                                         const BoundsAlongPath&);

}  // namespace qerr
