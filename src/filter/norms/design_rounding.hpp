#pragma once

#include "qerr/filter/filter.hpp"

namespace qerr {

/// Relative allowance for a norm of a designed filter against the norm of the ideal one: a design computes
/// its coefficients with a few roundings to double. 0 for filters that are not designed by a family.
inline double design_rounding(const Filter& filter) {
  constexpr double of_section = 1e-15;
  return filter.designed ? of_section * static_cast<double>(1 + filter.sections.size()) : 0;
}

}  // namespace qerr
