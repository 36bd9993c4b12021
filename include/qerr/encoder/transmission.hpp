#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "qerr/encoder/coupling.hpp"
#include "qerr/encoder/encoder.hpp"

namespace qerr {

/// From encoder space to joint space: joint coordinates = coupling * (encoder angles / gear ratio).
///
/// With `coupling` = I every joint has its own encoder (the case of the paper). A differential or a joint
/// measured relative to the ground has off-diagonal entries. Joint errors are then neither uniform nor
/// independent: propagation from encoder space is exact, Eq. (9) of the paper is not.
struct Transmission {
  std::vector<Encoder>
      encoders;       ///< one per independent joint, in chain order, on the joint side of its gear
  Coupling coupling;  ///< n x n, row: joint, column: encoder; not singular
};

/// Quantization interval of every encoder, in chain order [rad or m].
Eigen::VectorXd resolutions(const Transmission&);

/// Mean error of every encoder, in chain order [rad or m].
Eigen::VectorXd mean_errors(const Transmission&);

}  // namespace qerr
