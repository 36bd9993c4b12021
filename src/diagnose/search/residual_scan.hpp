#pragma once

#include "diagnose/search/error_model.hpp"

namespace qerr {

/// Looks in a residual for orders and loaded orders, lines in time, steps and bumps that the scanned ones do
/// not have, and adds them.
/// @param residual  one per sample [rad or m]
/// @returns whether there was any
bool scan_residual(const ErrorModel&, const Eigen::ArrayXd& residual, Scanned&);

}  // namespace qerr
