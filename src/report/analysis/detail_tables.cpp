#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "qerr/kinematics/coordinates.hpp"
#include "report/analysis/tables.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

/// The statistics that tables show: percentiles, then the maximum.
std::vector<StatisticKind> columns() {
  std::vector<StatisticKind> list;
  for (const StatisticKind& kind : statistic_kinds())
    if (!kind.heading.empty()) list.push_back(kind);
  std::stable_partition(list.begin(), list.end(), [](const auto& kind) { return kind.percentile >= 0; });
  return list;
}

std::vector<std::string> headings() {
  std::vector<std::string> row{""};
  for (const StatisticKind& kind : columns()) row.emplace_back(kind.heading);
  return row;
}

std::vector<std::string> figures(const std::string& label, const Statistic& s, const std::string& unit) {
  std::vector<std::string> row{label};
  for (const StatisticKind& kind : columns()) row.push_back(readable(cleaned(s.*kind.value), unit));
  return row;
}

const char* sigma_label(const Analysis& a) {
  return has_effects(a) ? "  sigma (IPQN, effects)" : "  sigma (IPQN)";
}

/// @param group  of closed loops: `closed_torque`; "": of all other signals
std::string position_table(const Analysis& a, const std::string& group, const Style& style) {
  const std::vector<Signal> coordinates = all_signals(a.spec.model);
  std::vector<std::vector<std::string>> rows{headings()};
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    const bool closed = is_closed(coordinates[i]);
    if ((closed ? coordinates[i].kind->group : "") != group) continue;
    const CoordinateStatistics& c = a.workspace.coordinates[i];
    const std::string name = closed ? coordinates[i].name.substr(group.size() + 1) : coordinates[i].name,
                      &unit = coordinates[i].unit;
    rows.push_back(figures(name + sigma_label(a), c.sigma, unit));
    rows.push_back(figures(name + "  worst case", c.worst_case, unit));
    if (!closed && std::isfinite(c.worst_case_rigorous.min))
      rows.push_back(figures(name + "  worst case, rigorous", c.worst_case_rigorous, unit));
  }
  return rows.size() > 1 ? fitted_table(rows, style.width) : "";
}

std::string derivative_table(const Analysis& a, std::size_t f, const Style& style) {
  const std::vector<Signal> coordinates = all_signals(a.spec.model);
  std::vector<std::vector<std::string>> rows{headings()};
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    const Signal& c = coordinates[i];
    if (!is_filtered(a.spec.filters[f], c)) continue;
    const std::string unit = shown_unit(c.unit, a.spec.filters[f].filter);
    if (const auto& sigma = a.workspace.derivatives[f][i].sigma)
      rows.push_back(figures(c.name + sigma_label(a), *sigma, unit));
    else
      rows.push_back({c.name + "  sigma: not known"});
    if (const auto& alone = a.workspace.derivatives[f][i].sigma_quantization)
      rows.push_back(figures(c.name + "  sigma of quantization", *alone, unit));
    if (const auto& moving = a.workspace.derivatives[f][i].sigma_in_motion)
      rows.push_back(figures(c.name + "  sigma in motion", *moving, unit));
    rows.push_back(figures(c.name + "  worst case", a.workspace.derivatives[f][i].worst_case, unit));
  }
  return fitted_table(rows, style.width);
}

}  // namespace

std::string detail_tables(const Analysis& a, const Style& style) {
  std::string out = heading("Position of the tip, estimate minus true, over the configurations", style) +
                    position_table(a, "", style);
  std::vector<std::string> groups;  // of closed loops
  for (const Signal& signal : all_signals(a.spec.model))
    if (is_closed(signal) && (groups.empty() || groups.back() != signal.kind->group))
      groups.emplace_back(signal.kind->group);
  for (const std::string& group : groups)
    out += heading("Loops closed: " + group + " due to errors", style) + position_table(a, group, style);
  out += ellipsoid_tables(a, style);
  for (std::size_t f = 0; f < a.spec.filters.size(); ++f)
    out += heading("Filter '" + escaped(a.spec.filters[f].name, 40) + "': " + norm_text(a.spec.filters[f]),
                   style) +
           derivative_table(a, f, style);
  if (a.spec.motion && !a.spec.filters.empty())
    out += '\n' + wrapped(
                      "sigma in motion: encoders move as in `motion:`, Jacobians are those of the "
                      "configurations",
                      style.width, "  ");
  return out;
}

}  // namespace qerr
