#include "report/page/axis.hpp"

#include <algorithm>
#include <cmath>

#include "core/text.hpp"

namespace qerr::page {

namespace {

std::string titled(const AxisRange& range, const std::string& unit) {
  return unit.empty() ? range.label : range.label + " [" + unit + ']';
}

/// The smallest of 1, 2, 5 times a power of ten that is not below the value.
double round_step(double least) {
  const double power = std::pow(10, std::floor(std::log10(least)));
  for (const double digit : {1.0, 2.0, 5.0})
    if (digit * power >= least * (1 - 1e-9)) return digit * power;
  return 10 * power;
}

Axis linear(const AxisRange& range, double least, double largest, int most) {
  const double magnitude = std::max(std::abs(least), std::abs(largest));
  // Labels have six digits: a spread below 1e-4 would give ticks that read alike. It is drawn as one value in
  // the middle.
  if (!(largest - least > 1e-4 * magnitude)) {
    const double half = magnitude == 0 ? 1 : 0.5 * magnitude;
    least -= half;
    largest += half;
  }
  const double step = round_step((largest - least) / most);
  const double first = std::floor(least / step + 1e-9), last = std::ceil(largest / step - 1e-9);
  const PrefixedUnit unit = range.unit.empty() || !range.prefix
                                ? PrefixedUnit{1, range.unit}
                                : prefixed(std::max(std::abs(first), std::abs(last)) * step, range.unit);
  Axis a{titled(range, unit.unit), false, first * step, last * step, {}};
  for (double k = first; k <= last + 0.5; ++k)
    a.ticks.push_back({k * step, significant(k * step / unit.factor, 6)});
  return a;
}

Axis logarithmic(const AxisRange& range, double least, double largest, int most) {
  const double first = std::floor(std::log10(least) + 1e-9);
  const double last = std::max(std::ceil(std::log10(largest) - 1e-9), first + 1);
  const double every = std::max(1.0, std::ceil((last - first) / most));
  Axis a{titled(range, range.unit), true, std::pow(10, first), std::pow(10, last), {}};
  for (double decade = first; decade <= last; decade += every)
    for (const double digit : {1.0, 2.0, 5.0}) {
      const double value = digit * std::pow(10, decade);
      if ((digit > 1 && last - first > 2) || value > a.to * (1 + 1e-9)) continue;
      a.ticks.push_back({value, significant(value, 6)});
    }
  return a;
}

}  // namespace

double Axis::part(double value) const {
  return logarithmic ? std::log(value / from) / std::log(to / from) : (value - from) / (to - from);
}

Axis axis(const AxisRange& range, double least, double largest, int most) {
  return range.logarithmic ? logarithmic(range, least, largest, most) : linear(range, least, largest, most);
}

}  // namespace qerr::page
