#include "report/sweep/drawn_variants.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/text.hpp"
#include "qerr/core/quantity.hpp"
#include "report/text_table.hpp"

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

std::vector<SweepAbscissa> abscissas_of(const SweepGrid& grid) {
  std::vector<SweepAbscissa> all;
  for (const SweepColumn& column : grid.columns())
    if (all.empty() || all.back().axis != column.axis)
      if (auto a = numeric_key(column)) all.push_back(std::move(*a));
  return all;
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

namespace {

constexpr std::size_t most_lines = 4;  ///< with a limit as many as the page has styles of lines
constexpr std::size_t most_bars = 20, point_bytes = 36, bar_bytes = 700;

/// The number of the variant with these steps.
std::uint64_t number_of(const SweepGrid& grid, const std::vector<std::size_t>& steps) {
  std::uint64_t number = 0;
  for (std::size_t a = 0; a < steps.size(); ++a) number = number * grid.axes()[a].steps.size() + steps[a];
  return number;
}

/// The steps of the other axes in their combination `index`, the first axis slowest.
std::vector<std::size_t> other_steps(const SweepGrid& grid, std::size_t without, std::uint64_t index) {
  std::vector<std::size_t> steps(grid.axes().size());
  for (std::size_t a = steps.size(); a-- > 0;) {
    if (a == without) continue;
    const std::size_t size = grid.axes()[a].steps.size();
    steps[a] = static_cast<std::size_t>(index % size);
    index /= size;
  }
  return steps;
}

std::string name_of_line(const SweepGrid& grid, std::size_t without, const std::vector<std::size_t>& steps) {
  std::vector<std::string> all;
  for (std::size_t a = 0; a < steps.size(); ++a) {
    const SweepAxis& axis = grid.axes()[a];
    for (std::size_t k = 0; k < axis.keys.size() && a != without; ++k)
      all.push_back(axis.keys[k] + " = " + short_value(axis.steps[steps[a]].names[k]));
  }
  return all.empty() ? "all variants" : joined(all);
}

}  // namespace

double DrawnVariants::value(const SweepGrid& grid, std::uint64_t variant) const {
  return abscissa->values[grid.steps(variant)[abscissa->axis]];
}

namespace {

DrawnVariants drawn_bars(const SweepGrid& grid, std::size_t figures, std::size_t most_bytes) {
  DrawnVariants d;
  d.points_in_all = static_cast<std::size_t>(grid.count());
  const std::size_t bars =
      std::clamp<std::size_t>(most_bytes / (bar_bytes * std::max<std::size_t>(figures, 1)), 2, most_bars);
  DrawnVariants::Line& line = d.lines.emplace_back();
  for (const std::size_t v : evenly_chosen(d.points_in_all, bars)) line.variants.push_back(v);
  return d;
}

DrawnVariants drawn_lines(const SweepGrid& grid, const SweepAbscissa& a, std::size_t figures,
                          std::size_t most_bytes) {
  DrawnVariants d;
  d.abscissa = a;
  d.points_in_all = a.values.size();
  d.lines_in_all = grid.count() / d.points_in_all;
  const std::vector<std::size_t> lines = evenly_chosen(static_cast<std::size_t>(d.lines_in_all), most_lines);
  const std::size_t points = std::clamp<std::size_t>(
      most_bytes / (point_bytes * lines.size() * std::max<std::size_t>(figures, 1)), 2, 400);
  for (const std::size_t index : lines) {
    std::vector<std::size_t> steps = other_steps(grid, a.axis, index);
    DrawnVariants::Line& line = d.lines.emplace_back();
    line.name = name_of_line(grid, a.axis, steps);
    for (const std::size_t i : evenly_chosen(d.points_in_all, points)) {
      steps[a.axis] = a.order[i];
      line.variants.push_back(number_of(grid, steps));
    }
  }
  return d;
}

}  // namespace

std::vector<DrawnVariants> drawn_variants(const SweepGrid& grid, std::size_t figures,
                                          std::size_t most_bytes) {
  constexpr std::size_t most_keys = 4;
  std::vector<SweepAbscissa> keys = abscissas_of(grid);
  if (keys.empty()) return {drawn_bars(grid, figures, most_bytes)};
  if (keys.size() > most_keys) keys.resize(most_keys);
  std::vector<DrawnVariants> all;
  for (const SweepAbscissa& key : keys)
    all.push_back(drawn_lines(grid, key, figures, most_bytes / keys.size()));
  return all;
}

}  // namespace qerr
