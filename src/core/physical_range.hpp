#pragma once

#include "qerr/core/parameter.hpp"

namespace qerr {

/// Magnitudes that a quantity can have in a machine [SI units].
struct PhysicalRange {
  double smallest = 0;  ///< of those that are not 0
  double largest = 0;
};

/// What physics leaves for a dimension; a wide range of numbers, whose squares do not overflow, for those
/// that are not in the table (src/core/physical_range.cpp).
PhysicalRange physical_range(const Dimension&);

/// The parameter with the bounds of physics where its row states none: the largest magnitude, and the
/// smallest one where only zero is excluded.
/// @param coordinate  of a joint coordinate, for rows that have one
Parameter with_physical_range(Parameter, const Dimension& coordinate);

}  // namespace qerr
