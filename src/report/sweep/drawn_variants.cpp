#include "report/sweep/drawn_variants.hpp"

#include <algorithm>

namespace qerr {

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
  std::string name;
  for (std::size_t a = 0; a < steps.size(); ++a) {
    if (a == without) continue;
    const SweepAxis& axis = grid.axes()[a];
    for (std::size_t k = 0; k < axis.keys.size(); ++k)
      name += (name.empty() ? "" : ", ") + axis.keys[k] + " = " + short_value(axis.steps[steps[a]].names[k]);
  }
  return name.empty() ? "all variants" : name;
}

}  // namespace

double DrawnVariants::value(const SweepGrid& grid, std::uint64_t variant) const {
  return abscissa->values[grid.steps(variant)[abscissa->axis]];
}

DrawnVariants drawn_variants(const SweepGrid& grid, std::size_t figures, std::size_t most_bytes) {
  DrawnVariants d;
  d.abscissa = abscissa_of(grid);
  if (!d.abscissa) {
    d.points_in_all = static_cast<std::size_t>(grid.count());
    const std::size_t bars =
        std::clamp<std::size_t>(most_bytes / (bar_bytes * std::max<std::size_t>(figures, 1)), 2, most_bars);
    DrawnVariants::Line& line = d.lines.emplace_back();
    for (const std::size_t v : evenly_chosen(d.points_in_all, bars)) line.variants.push_back(v);
    return d;
  }
  const SweepAbscissa& a = *d.abscissa;
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

}  // namespace qerr
