#pragma once

#include <vector>

#include "qerr/bound/derivative_error.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/simulate/simulate.hpp"

namespace qerr {

/// What theory says of a motion: at its centre, along its path, and with the encoders' true speeds.
class TheoryAlongPath {
 public:
  struct Signal {
    double ipqn = 0, ipqn_path = 0, exact = 0, worst_case = 0, worst_case_path = 0;
  };

  TheoryAlongPath(const OperationalModel&, const std::vector<Filter>&, const std::vector<Norms>&,
                  const Motion&, std::uint64_t samples, std::uint64_t settling);

  /// @param output  0: the position itself, then the filters
  Signal of(std::size_t output, Eigen::Index coordinate) const {
    return signals_[output][static_cast<std::size_t>(coordinate)];
  }

 private:
  std::vector<std::vector<Signal>> signals_;
};

}  // namespace qerr
