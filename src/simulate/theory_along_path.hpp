#pragma once

#include <vector>

#include "qerr/bound/derivative_error.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/simulate/simulate.hpp"

namespace qerr {

/// Squared Jacobians and bounds at the samples of a motion, accumulated during the simulation: by stretches,
/// since the spectrum of a quantization error depends on the speed of the joint.
class AlongPath {
 public:
  /// @param stretches  a power of two; 1 if speeds are not needed
  AlongPath(Eigen::Index coordinates, Eigen::Index encoders, std::size_t stretches);

  std::size_t stretches() const { return static_cast<std::size_t>(squares_.cols()); }

  /// Sums of (J C Delta)^2 over the samples of a stretch after the settling, [encoder][coordinate], followed
  /// by padding to whole lanes.
  double* squares(std::size_t stretch) { return squares_.col(static_cast<Eigen::Index>(stretch)).data(); }
  /// Counts samples whose squares have been added.
  void count(std::size_t samples) { counted_ += static_cast<double>(samples); }
  /// Includes bounds at samples, those of the settling as well, since a filter has a memory.
  void bound_by(const Eigen::VectorXd& rigorous, const Eigen::VectorXd& deviation);
  void append(const AlongPath& later);

  /// Mean of (J C Delta)^2, coordinates x encoders, over all stretches.
  Eigen::MatrixXd mean_squares() const;
  /// The same with a weight for every stretch and encoder.
  /// @param weights  rows x encoders; the number of rows is a power of two up to `stretches()`
  Eigen::MatrixXd mean_squares(const Eigen::MatrixXd& weights) const;

  const Eigen::VectorXd& rigorous() const { return rigorous_; }  ///< largest bound of the position error
  /// Largest bound of its difference from the mean error at the centre. A filter multiplies the mean by
  /// |H(1)| and the bound of the difference by its l1 norm.
  const Eigen::VectorXd& deviation() const { return deviation_; }

 private:
  static constexpr Eigen::Index most_lanes = 8;

  double counted_ = 0;
  Eigen::Index encoders_;
  Eigen::MatrixXd squares_;  // a column for every stretch
  Eigen::VectorXd rigorous_, deviation_;
};

/// Theory of one coordinate after one filter; the members are those of `SimulatedSignal`.
struct SignalTheory {
  double ipqn = 0, ipqn_path = 0, exact = 0, worst_case = 0, worst_case_path = 0;
};

/// Theory of all signals.
/// @param middle  error at the centre of the motion
/// @returns [0: the position itself, then the filters][coordinate]
std::vector<std::vector<SignalTheory>> theory_along_path(const OperationalError& middle, const Transmission&,
                                                         const std::vector<Filter>&,
                                                         const std::vector<Norms>&, const Motion&,
                                                         std::uint64_t settling, const AlongPath&);

}  // namespace qerr
