#pragma once

#include "qerr/bound/operational_error.hpp"

namespace qerr {

/// Derivative of the model's coordinates with respect to an error at a joint, an encoder or a joint's origin
/// [m or rad per unit of the error].
/// @param rotation      of the tip in the base frame
/// @param joint_rows    rows of the coordinates, by independent joints (J)
/// @param encoder_rows  the same by encoders (J C)
Eigen::VectorXd error_column(const IndependentError&, const OperationalModel&, const Eigen::VectorXd& q,
                             const Eigen::Matrix3d& rotation, const Eigen::MatrixXd& joint_rows,
                             const Eigen::MatrixXd& encoder_rows);

}  // namespace qerr
