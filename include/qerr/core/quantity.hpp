#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace qerr {

/// Exponents of the base units m, rad, s, N, K. The radian is a base unit, so that lengths and angles are not
/// confused.
struct Dimension {
  int metre = 0, radian = 0, second = 0, newton = 0, kelvin = 0;
  bool operator==(const Dimension&) const = default;
};

namespace dimension {
inline constexpr Dimension none{}, length{1}, angle{0, 1}, time{0, 0, 1}, frequency{0, 0, -1},
    speed{1, 0, -1}, angular_speed{0, 1, -1}, angular_acceleration{0, 1, -2}, torque{1, 0, 0, 1},
    compliance{-1, 1, 0, -1}, damping{1, -1, 1, 1}, inertia{1, -1, 2, 1}, temperature{0, 0, 0, 0, 1},
    angle_per_temperature{0, 1, 0, 0, -1};
}  // namespace dimension

/// The SI name of a dimension, such as `rad`, `m/s^2`, `rad/(N m)`, or "" for a pure number.
std::string unit_name(const Dimension&);

/// A number in SI units; `dimension` is empty if it was written without a unit.
struct Quantity {
  double value = 0;
  std::optional<Dimension> dimension;
};

/// Parses a decimal number, independently of the locale: the whole text, finite, not hexadecimal, without
/// underflow to zero.
/// @returns empty if `text` is not such a number
std::optional<double> parse_number(std::string_view text);

/// A number or a fraction of two numbers with an optional unit: `50 Hz`, `0.125 mrad`, `1/100`, `5 mm/s`,
/// `2 rad/s^2`, `3 rad/(N m)`, `12 %`.
///
/// Prefixes n u (or µ) m c k M of m, rad, deg, gon, rev, s, Hz, N; further units are in, arcmin, arcsec, rpm,
/// min, h, d, K, degC.
/// @returns empty, with `why` set, if the text is not a number or the unit is unknown
std::optional<Quantity> parse_quantity(std::string_view text, std::string& why);

/// Shortest text that reads back as the same double, independent of the locale.
std::string shortest(double value);

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
/// parse_quantity; a number before it is what one step of the column is: `0.1 deg`, `360/4096 deg`.
/// @returns empty, with `why` set, if the unit is unknown
std::optional<Unit> parse_unit(std::string_view text, std::string& why);

}  // namespace qerr
