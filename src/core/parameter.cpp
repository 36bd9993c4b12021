#include "qerr/core/parameter.hpp"

#include <cmath>

namespace qerr {

namespace {

struct DimensionRange {
  Dimension dimension;
  PhysicalRange range;
};

/// The diameter of a proton is 1.7e-15 m and that of the Earth 1.3e7 m. An angle of 1e-15 rad is a proton at
/// the end of an arm of a metre; 1e9 rad are two days of a spindle at 60 000 rpm. Light needs 1e-15 s for 0.3
/// um, and the universe is 4e17 s old. Nothing is faster than light.
/// A joint that turns by 1e6 rad under 1 N m, or by 1e3 rad in 1 K, is none.
constexpr DimensionRange ranges[]{
    {dimension::length, {1e-15, 1e8}},
    {dimension::angle, {1e-15, 1e9}},
    {dimension::time, {1e-15, 1e18}},
    {dimension::frequency, {1e-18, 1e15}},
    {dimension::speed, {1e-15, 3e8}},
    {dimension::angular_speed, {1e-15, 1e9}},
    {{1, 0, -2}, {1e-15, 1e15}},
    {dimension::angular_acceleration, {1e-15, 1e15}},
    {dimension::torque, {1e-15, 1e15}},
    {{0, 0, 0, 1}, {1e-15, 1e15}},
    {dimension::temperature, {1e-12, 1e9}},
    {dimension::compliance, {1e-15, 1e6}},
    {dimension::angle_per_temperature, {1e-15, 1e3}},
};

/// Of other quantities and of pure numbers: the squares of such numbers are normal doubles, and the
/// coefficients of an eighth derivative at 1 MHz (1e48) are among them.
constexpr PhysicalRange other{1e-60, 1e60};

}  // namespace

PhysicalRange physical_range(const Dimension& d) {
  for (const DimensionRange& r : ranges)
    if (r.dimension == d) return r.range;
  return other;
}

Parameter with_physical_range(Parameter p, const Dimension& coordinate) {
  const PhysicalRange range = physical_range(p.coordinate ? coordinate : p.dimension);
  if (p.kind == Kind::integer) return p;
  if (p.open_below && p.least == 0) {
    p.least = range.smallest;
    p.open_below = false;
  }
  if (!std::isfinite(p.least)) p.least = -range.largest;
  if (!std::isfinite(p.most)) p.most = range.largest;
  return p;
}

}  // namespace qerr
