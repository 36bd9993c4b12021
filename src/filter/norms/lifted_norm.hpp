#pragma once

#include "qerr/filter/filter.hpp"

namespace qerr {

/// An upper bound of sqrt(sum (1 + lift)^(2k) h_k^2), the H2 norm of H(z/(1 + lift)), within 10 % of it;
/// infinite unless every pole is proven to be inside |z| < 1/(1 + lift).
/// @pre no taps
double lifted_norm(const Filter&, double lift);

}  // namespace qerr
