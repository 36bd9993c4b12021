#include "input/quantity_words.hpp"

namespace qerr {

namespace {

/// A kind of quantity as people call it, and units in which it is usually written.
struct QuantityName {
  Dimension dimension;
  std::string_view name, units;
};

constexpr QuantityName quantity_names[]{
    {dimension::none, "a plain number", ""},
    {dimension::angle, "an angle", "rad, mrad, deg, arcmin or arcsec"},
    {dimension::length, "a length", "m, mm or um"},
    {dimension::time, "a time", "s, ms or us"},
    {dimension::frequency, "a frequency", "Hz or kHz"},
    {dimension::speed, "a speed", "m/s or mm/s"},
    {dimension::angular_speed, "an angular speed", "rad/s, deg/s or rpm"},
    {{1, 0, -2}, "an acceleration", "m/s^2 or mm/s^2"},
    {{0, 1, -2}, "an angular acceleration", "rad/s^2 or deg/s^2"},
};

}  // namespace

std::string name_of(const Dimension& d) {
  for (const QuantityName& q : quantity_names)
    if (q.dimension == d) return std::string(q.name);
  return "a quantity in " + unit_name(d);
}

std::string unit_remedy(const Dimension& d) {
  for (const QuantityName& q : quantity_names)
    if (q.dimension == d)
      return "give " + std::string(q.name) + (q.units.empty() ? "" : " in " + std::string(q.units));
  return "give a number in " + unit_name(d);
}

}  // namespace qerr
