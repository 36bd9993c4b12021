#pragma once

#include "qerr/filter/filter.hpp"

namespace qerr {

/// Relative allowance for a norm of a designed filter against the norm of the ideal one: a design computes
/// its coefficients with a few roundings to double. 0 for filters that are not designed by a family.
inline double design_rounding(const Filter& filter) {
  constexpr double of_section = 1e-15;
  return filter.designed ? of_section * static_cast<double>(1 + filter.sections.size()) : 0;
}

/// An upper bound of sqrt(sum (1 + lift)^(2k) h_k^2), the H2 norm of H(z/(1 + lift)), within 10 % of it;
/// infinite unless every pole is proven to be inside |z| < 1/(1 + lift).
/// @pre no taps
double lifted_norm(const Filter&, double lift);

}  // namespace qerr
