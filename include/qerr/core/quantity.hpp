#pragma once

#include <optional>
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
    speed{1, 0, -1}, angular_speed{0, 1, -1}, torque{1, 0, 0, 1}, compliance{-1, 1, 0, -1},
    temperature{0, 0, 0, 0, 1}, angle_per_temperature{0, 1, 0, 0, -1};
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
/// Prefixes n u (or µ) m c k M of m, rad, s, Hz, N; further units are in, deg, arcmin, arcsec, rev, rpm, min,
/// h, K, degC.
/// @returns empty, with `why` set, if the text is not a number or the unit is unknown
std::optional<Quantity> parse_quantity(std::string_view text, std::string& why);

/// Shortest text that reads back as the same double, independent of the locale.
std::string shortest(double value);

}  // namespace qerr
