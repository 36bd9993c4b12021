#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "qerr/encoder/encoder.hpp"

namespace qerr {

/// From encoder space to joint space: joint coordinates = coupling * (encoder angles / gear ratio).
///
/// With `coupling` = I every joint has its own encoder (the paper's case). A differential, or a joint that is
/// measured against the ground, has off-diagonal entries; the joint error is then neither uniform nor
/// independent, and propagation from encoder space stays exact where the paper's Eq. (9) is not.
struct Transmission {
  std::vector<Encoder>
      encoders;              ///< one per independent joint, in chain order, on the joint side of its gear
  Eigen::MatrixXd coupling;  ///< n x n, row: joint, column: encoder; regular
};

/// Quantization interval of every encoder, in chain order [rad or m].
Eigen::VectorXd resolutions(const Transmission&);

/// Mean error of every encoder, in chain order [rad or m].
Eigen::VectorXd mean_errors(const Transmission&);

}  // namespace qerr
