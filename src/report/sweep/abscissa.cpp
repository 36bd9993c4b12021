#include "report/sweep/abscissa.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/text.hpp"
#include "qerr/core/quantity.hpp"

namespace qerr {

namespace {

/// Whether ascending values have equal ratios, within the digits with which a spec states them, and do not
/// have equal differences.
bool equal_ratios(const std::vector<double>& v) {
  constexpr double tolerance = 0.02;
  if (v.size() < 3 || !(v.front() > 0)) return false;
  const double steps = static_cast<double>(v.size() - 1);
  const double ratio = std::log(v.back() / v.front()) / steps, step = (v.back() - v.front()) / steps;
  bool in_log = true, linear = true;
  for (std::size_t i = 1; i < v.size(); ++i) {
    in_log = in_log && std::abs(std::log(v[i] / v[i - 1]) - ratio) <= tolerance * ratio;
    linear = linear && std::abs(v[i] - v[i - 1] - step) <= tolerance * step;
  }
  return in_log && !linear;
}

/// The values of a key, or none if they are not numbers, two different ones at least.
std::optional<SweepAbscissa> numeric_key(const SweepColumn& column) {
  SweepAbscissa a{column.axis, column.key, column.unit, column.values, {}, false};
  a.order.resize(a.values.size());
  std::iota(a.order.begin(), a.order.end(), std::size_t{0});
  std::stable_sort(a.order.begin(), a.order.end(),
                   [&](std::size_t x, std::size_t y) { return a.values[x] < a.values[y]; });
  if (a.values.empty() || a.values[a.order.front()] == a.values[a.order.back()]) return std::nullopt;
  std::vector<double> ascending;
  for (const std::size_t step : a.order)
    if (ascending.empty() || a.values[step] > ascending.back()) ascending.push_back(a.values[step]);
  a.logarithmic = equal_ratios(ascending);
  return a;
}

}  // namespace

std::optional<SweepAbscissa> abscissa_of(const SweepGrid& grid) {
  for (const SweepColumn& column : grid.columns())
    if (auto a = numeric_key(column)) return a;
  return std::nullopt;
}

std::string short_value(const std::string& name) {
  constexpr std::size_t long_number = 9;
  const std::string number = name.substr(0, name.find_first_not_of("0123456789.+-eE"));
  const auto value = parse_number(number);
  return value && number.size() >= long_number ? significant(*value, 6) + name.substr(number.size()) : name;
}

std::vector<std::size_t> evenly_chosen(std::size_t count, std::size_t most) {
  std::vector<std::size_t> chosen;
  const std::size_t wanted = std::min(count, most);
  for (std::size_t i = 0; i < wanted; ++i) chosen.push_back(wanted == 1 ? 0 : i * (count - 1) / (wanted - 1));
  return chosen;
}

}  // namespace qerr
