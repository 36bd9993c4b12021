#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "qerr/core/quantity.hpp"

namespace qerr {

/// A unit: value in SI units = value * factor / divisor. Both are integers for decimal prefixes, so that 30
/// um is rounded once, to the double nearest to 3e-5.
struct Unit {
  double factor = 1;
  double divisor = 1;
  Dimension dimension;

  double in_si(double value) const { return value * factor / divisor; }
};

/// A word of which units are made.
struct UnitSymbol {
  std::string_view name;
  double factor;  ///< its size in SI units
  Dimension dimension;
  bool prefixable = false;  ///< whether one of unit_prefixes may stand before it
};
std::span<const UnitSymbol> unit_symbols();

/// A decimal prefix: factor / divisor.
struct UnitPrefix {
  std::string_view name;
  double factor = 1;
  double divisor = 1;
};
std::span<const UnitPrefix> unit_prefixes();

/// Parses a unit, as in the header of a column: `rad`, `mm/s`, `N m`, `1`. The units are those of
/// parse_quantity.
/// @returns empty, with `why` set, if the unit is unknown
std::optional<Unit> parse_unit(std::string_view text, std::string& why);

}  // namespace qerr
