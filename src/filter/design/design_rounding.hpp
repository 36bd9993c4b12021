#pragma once

#include "qerr/filter/filter.hpp"

namespace qerr {

/// By how much of itself a norm of the filter that a family means may differ from that of the filter it
/// designed: the coefficients of a design are a few roundings to double from the ideal. 0 for stated ones.
inline double design_rounding(const Filter& filter) {
  constexpr double of_section = 1e-15;
  return filter.designed ? of_section * static_cast<double>(1 + filter.sections.size()) : 0;
}

}  // namespace qerr
