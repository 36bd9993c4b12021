#pragma once

#include "qerr/bound/operational_error.hpp"
#include "qerr/simulate/log.hpp"

namespace qerr {

// What a log's columns, which are of joints, say in the coordinate of an encoder, which may feel several.

/// Whether an encoder feels its own joint only.
bool depends_on_one_joint(const OperationalModel&, Eigen::Index encoder);

/// By the references of all joints that the encoder feels.
struct EncoderReference {
  Eigen::ArrayXd position;    ///< empty where a reference is missing [rad or m]
  double log_resolution = 0;  ///< the coarsest step that one of them is written with [rad or m]
};
EncoderReference encoder_reference(const OperationalModel&, const Log&, Eigen::Index encoder);

/// By the positions that the robot knows of these joints (measured_joint); empty where one is missing
/// [rad or m].
Eigen::ArrayXd encoder_measured(const OperationalModel&, const Log&, Eigen::Index encoder);

}  // namespace qerr
