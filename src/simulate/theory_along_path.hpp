#pragma once

#include <vector>

#include "qerr/bound/derivative_error.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/simulate/simulate.hpp"

namespace qerr {

/// What the Jacobian says at the samples of a motion, gathered while they are simulated: in stretches, since
/// where a joint moves slowly its error is another than where it moves fast.
class AlongPath {
 public:
  /// @param stretches  a power of two: 1 where nothing asks how fast the joints move
  AlongPath(Eigen::Index coordinates, Eigen::Index encoders, std::size_t stretches);

  std::size_t stretches() const { return static_cast<std::size_t>(squares_.cols()); }

  /// Where sums of (J C Delta)^2 over samples of a stretch of the part that counts are added: encoder after
  /// encoder, a number of each coordinate; behind them there is room for what fills up the last lanes.
  double* squares(std::size_t stretch) { return squares_.col(static_cast<Eigen::Index>(stretch)).data(); }
  /// So many samples have been added.
  void count(std::size_t samples) { counted_ += static_cast<double>(samples); }
  /// All samples, before the part that counts too: a filter remembers what was there.
  void bound_by(const Eigen::VectorXd& rigorous, const Eigen::VectorXd& deviation);
  void append(const AlongPath& later);

  /// Mean of (J C Delta)^2, coordinates x encoders: over the whole, and with weights for the parts.
  Eigen::MatrixXd mean_squares() const;
  /// @param weights  stretches x encoders; a power of two of them, up to `stretches()`
  Eigen::MatrixXd mean_squares(const Eigen::MatrixXd& weights) const;

  const Eigen::VectorXd& rigorous() const { return rigorous_; }  ///< largest bound of the position error
  /// And of its difference from the mean error at the centre: a filter makes |H(1)| of that one, and the l1
  /// norm of what differs from it.
  const Eigen::VectorXd& deviation() const { return deviation_; }

 private:
  static constexpr Eigen::Index most_lanes = 8;

  double counted_ = 0;
  Eigen::Index encoders_;
  Eigen::MatrixXd squares_;  // of a stretch in each column
  Eigen::VectorXd rigorous_, deviation_;
};

/// Theory of one coordinate behind one filter (SimulatedSignal says what each is).
struct SignalTheory {
  double ipqn = 0, ipqn_path = 0, exact = 0, worst_case = 0, worst_case_path = 0;
};

/// @param middle  error at the centre of the motion
/// @returns [0: the position itself, then the filters][coordinate]
std::vector<std::vector<SignalTheory>> theory_along_path(const OperationalError& middle, const Transmission&,
                                                         const std::vector<Filter>&,
                                                         const std::vector<Norms>&, const Motion&,
                                                         std::uint64_t settling, const AlongPath&);

}  // namespace qerr
