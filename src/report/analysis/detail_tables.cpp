#include <algorithm>
#include <array>
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
  TableRows rows{headings()};
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
  TableRows rows{headings()};
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

namespace {

using Three = std::array<Coordinate, 3>;

/// Indices of three coordinates in the model; empty if one is missing.
std::optional<std::array<Eigen::Index, 3>> find_three(const OperationalModel& model, const Three& wanted) {
  std::array<Eigen::Index, 3> at{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto found = std::find(model.coordinates.begin(), model.coordinates.end(), wanted[i]);
    if (found == model.coordinates.end()) return std::nullopt;
    at[i] = found - model.coordinates.begin();
  }
  return at;
}

Eigen::Matrix3d block(const Eigen::MatrixXd& covariance, const std::array<Eigen::Index, 3>& at) {
  Eigen::Matrix3d three;
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t c = 0; c < 3; ++c)
      three(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c)) = covariance(at[r], at[c]);
  return three;
}

}  // namespace

std::vector<TipEllipsoids> tip_ellipsoids(const Analysis& a) {
  std::vector<TipEllipsoids> all;
  if (a.workspace.covariance_at_largest.size() == 0) return all;
  const auto add = [&](std::string_view of, std::string_view unit, const Three& coordinates) {
    if (const auto at = find_three(a.spec.model, coordinates))
      all.push_back({of, unit, error_ellipsoid(block(a.workspace.mean_covariance, *at)),
                     error_ellipsoid(block(a.workspace.covariance_at_largest, *at))});
  };
  add("position", "m", {Coordinate::x, Coordinate::y, Coordinate::z});
  add("rotation", "rad", {Coordinate::rx, Coordinate::ry, Coordinate::rz});
  return all;
}

std::string ellipsoid_tables(const Analysis& a, const Style& style) {
  const std::string axes = a.spec.model.frame == CoordinateFrame::tip ? "the tip" : "the base";
  std::string out;
  for (const TipEllipsoids& tip : tip_ellipsoids(a)) {
    TableRows rows{{"semi-axis", "sigma", "x", "y", "z"}};
    const auto add = [&](const std::string& where, const ErrorEllipsoid& e) {
      for (Eigen::Index i = 0; i < 3; ++i) {
        rows.push_back(
            {where + ' ' + std::to_string(i + 1), readable(e.semi_axes[i], std::string(tip.unit))});
        for (Eigen::Index c = 0; c < 3; ++c) rows.back().push_back(fixed_point(e.directions(c, i), 3));
      }
    };
    add("mean", tip.mean);
    add("largest", tip.at_largest);
    out += table_section(
        "Ellipsoid of one sigma of the " + std::string(tip.of) + ", directions in the axes of " + axes, rows,
        style);
  }
  if (!out.empty())
    out += wrapped(
        "mean: root mean square over the configurations; largest: where that of the position is largest",
        style.width, "  ");
  return out;
}

namespace {

std::string table_of(const Exceedance& e, const std::string& base, const Style& style) {
  std::string out =
      heading(shown(e.quantity) + " above " + readable(e.limit, e.unit) + ": " + std::to_string(e.above) +
                  " of " + std::to_string(e.count) + " configurations, " +
                  percent(static_cast<double>(e.above) / static_cast<double>(e.count)),
              style);
  if (e.above == 0) return out;
  TableRows rows{{"distance of the tip", "configurations", "above", "share"}};
  for (const Exceedance::Shell& s : e.by_distance)
    if (s.count > 0)
      rows.push_back({significant(s.from, 3) + " to " + significant(s.to, 3) + " m", std::to_string(s.count),
                      std::to_string(s.above),
                      percent(static_cast<double>(s.above) / static_cast<double>(s.count))});
  out += fitted_table(rows, style.width);
  std::string box = "distance: from the origin of " + escaped(base, 60) + "; above the limit the tip is at";
  const char* const names = "xyz";
  for (Eigen::Index i = 0; i < 3; ++i)
    box += std::string(i > 0 ? ", " : " ") + names[i] + ' ' + significant(e.lowest[i], 3) + " to " +
           significant(e.highest[i], 3) + " m";
  return out + wrapped(box, style.width, "  ");
}

}  // namespace

std::string exceedance_tables(const Analysis& a, const Style& style) {
  std::string out;
  for (const Exceedance& e : a.exceedances) out += table_of(e, a.spec.model.chain.base, style);
  return out;
}

}  // namespace qerr
