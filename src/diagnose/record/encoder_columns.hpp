#pragma once

#include "qerr/bound/operational_error.hpp"
#include "qerr/simulate/log.hpp"

namespace qerr {

// The columns of a log are joint coordinates; with a coupling the coordinate of an encoder is a combination
// of several joints.

/// Whether the encoder's coordinate depends on its own joint only.
bool depends_on_one_joint(const OperationalModel&, Eigen::Index encoder);

/// Reference of the encoder's coordinate, combined from the references of all joints that it depends on.
struct EncoderReference {
  Eigen::ArrayXd position;    ///< [rad or m]; empty if a joint's reference is missing
  double log_resolution = 0;  ///< coarsest step of these columns in the file [rad or m]
};
EncoderReference encoder_reference(const OperationalModel&, const Log&, Eigen::Index encoder);

/// The encoder's coordinate combined from the measured positions of these joints (measured_joint) [rad or m];
/// empty if one of them is missing.
Eigen::ArrayXd encoder_measured(const OperationalModel&, const Log&, Eigen::Index encoder);

}  // namespace qerr
