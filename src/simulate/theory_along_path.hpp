#pragma once

#include <vector>

#include "qerr/bound/derivative_error.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/simulate/simulate.hpp"

namespace qerr {

/// What the Jacobian says at the samples of a motion, gathered while they are simulated.
class AlongPath {
 public:
  AlongPath(Eigen::Index coordinates, Eigen::Index encoders);

  /// @param counts  whether the sample is part of the statistics; a filter remembers what was before them
  void add(const OperationalError&, bool counts);
  void append(const AlongPath& later);

  Eigen::MatrixXd mean_squares() const;                          ///< of (J C Delta), coordinates x encoders
  const Eigen::VectorXd& rigorous() const { return rigorous_; }  ///< largest bound of the position error

 private:
  double counted_ = 0;
  Eigen::MatrixXd squares_;
  Eigen::VectorXd rigorous_;
};

/// Theory of one coordinate behind one filter (SimulatedSignal says what each is).
struct SignalTheory {
  double ipqn = 0, ipqn_path = 0, exact = 0, worst_case = 0, worst_case_path = 0;
};

/// @returns [0: the position itself, then the filters][coordinate]
std::vector<std::vector<SignalTheory>> theory_along_path(const OperationalModel&, const std::vector<Filter>&,
                                                         const std::vector<Norms>&, const Motion&,
                                                         std::uint64_t settling, const AlongPath&);

}  // namespace qerr
