#pragma once

#include "qerr/filter/filter.hpp"

namespace qerr {

/// An upper bound of sqrt(sum (1 + lift)^(2k) h_k^2), the norm of H(z/(1 + lift)), a few digits tight;
/// infinite unless every pole is proven to lie inside |z| < 1/(1 + lift).
/// @pre no taps
double lifted_norm(const Filter&, double lift);

}  // namespace qerr
