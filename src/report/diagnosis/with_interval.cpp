#include <algorithm>
#include <cmath>
#include <numbers>

#include "report/diagnosis/parts.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

/// As many decimals as give the interval two digits.
std::string fitted(double value, double half, double scale, const std::string& unit) {
  const int decimals = std::clamp(1 - static_cast<int>(std::floor(std::log10(half / scale))), 0, 6);
  return fixed_point(value / scale, decimals) + " +- " + fixed_point(half / scale, decimals) + ' ' + unit;
}

/// Degrees have no SI prefix.
std::string figure(double value, const std::string& unit) {
  return unit == "deg" ? significant(value, 3) + " deg" : readable(value, unit);
}

}  // namespace

std::string with_interval(const ReportedParameter& parameter) {
  ReportedParameter p = parameter;
  if (p.figure.name == "phase" && p.unit == "rad") {
    for (double* angle : {&p.figure.value, &p.figure.lower, &p.figure.upper})
      *angle *= 180 / std::numbers::pi;
    p.unit = "deg";
  }
  const auto& [name, value, lower, upper] = p.figure;
  if (p.fixed)
    return p.unit.empty() || p.unit == "deg" ? significant(value, 6) + (p.unit.empty() ? "" : " deg")
                                             : readable(value, p.unit);
  const double half = 0.5 * (upper - lower);
  if (p.unit.empty())
    return significant(value, 4) + " (" + significant(lower, 4) + " .. " + significant(upper, 4) + ')';
  if (!(std::abs(0.5 * (upper + lower) - value) < 0.2 * half) || std::abs(value) < half)
    return figure(value, p.unit) + " (" + figure(lower, p.unit) + " .. " + figure(upper, p.unit) + ')';
  if (p.unit == "deg") return fitted(value, half, 1, "deg");
  // One prefix for both, and as many decimals as give the interval two digits.
  const int thousand =
      std::clamp(static_cast<int>(std::floor(std::log10(std::max(std::abs(value), half)) / 3)), -4, 3);
  static constexpr const char* prefixes[] = {"p", "n", "u", "m", "", "k", "M", "G"};
  return fitted(value, half, std::pow(1000.0, thousand), prefixes[thousand + 4] + p.unit);
}

}  // namespace qerr
