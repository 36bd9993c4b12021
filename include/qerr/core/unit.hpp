#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "qerr/core/quantity.hpp"

namespace qerr {

/// A unit: value in SI = value * factor / divisor. Both are whole for decimal prefixes, so that 30 um is the
/// double nearest to 3e-5, as it is when written as 30e-6.
struct Unit {
  double factor = 1;
  double divisor = 1;
  Dimension dimension;

  double in_si(double value) const { return value * factor / divisor; }
};

/// A unit alone, as the head of a table's column has it: `rad`, `mm/s`, `N m`, `1`. What is known is what
/// parse_quantity knows.
/// @returns empty, with `why` set, when the unit is not known
std::optional<Unit> parse_unit(std::string_view text, std::string& why);

}  // namespace qerr
