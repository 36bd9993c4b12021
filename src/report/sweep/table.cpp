#include <algorithm>

#include "report/analysis/tables.hpp"
#include "report/formats.hpp"
#include "report/sweep/run_sweep.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

constexpr char next_cell = '\t', next_row = '\n';  // no name has them

/// Words that the table can stack: of a dotted path each.
std::string stacked(std::string path) {
  std::replace(path.begin(), path.end(), '.', ' ');
  return shown(path);
}

/// The headers of the figures, where the spec has no requirements.
std::vector<std::string> headers(const Spec& spec) {
  std::vector<std::string> headers;
  if (!spec.requirements.empty()) {
    for (const Requirement& r : spec.requirements) headers.push_back(stacked(r.name()));
    headers.emplace_back("met");
    return headers;
  }
  const std::vector<Signal> coordinates = all_signals(spec.model);
  for (const Signal& c : coordinates) headers.push_back(c.name + " worst max");
  for (const NamedFilter& f : spec.filters)
    for (const Signal& c : coordinates)
      if (is_filtered(f, c)) headers.push_back(stacked(f.name) + ' ' + c.name + " sigma max");
  return headers;
}

}  // namespace

SweepTable::SweepTable(const SpecVariants& variants, const SweepGrid& grid)
    : variants_(variants), grid_(grid) {
  std::vector<std::string>& header = cells_.emplace_back();
  header.emplace_back("variant");
  for (const std::string& key : grid.keys()) header.push_back(stacked(key));
  for (std::string& figure : headers(variants.base())) header.push_back(std::move(figure));
}

std::vector<std::string> SweepTable::figures(const SpecCheck& check) const {
  std::vector<std::string> cells;
  const Analysis& a = check.analysis;
  if (!variants_.base().requirements.empty()) {
    for (std::size_t i = 0; i < check.results.size(); ++i)
      cells.push_back(readable(check.results[i].value, a.spec.requirements[i].unit));
    if (!check.results.empty()) cells.emplace_back(check.all_met() ? "yes" : "NO");
    return cells;
  }
  const std::vector<Signal> coordinates = all_signals(a.spec.model);
  for (std::size_t c = 0; c < coordinates.size(); ++c)
    cells.push_back(readable(a.workspace.coordinates[c].worst_case.max, coordinates[c].unit));
  for (std::size_t f = 0; f < a.spec.filters.size(); ++f)
    for (std::size_t c = 0; c < coordinates.size(); ++c) {
      if (!is_filtered(a.spec.filters[f], coordinates[c])) continue;
      const auto& sigma = a.workspace.derivatives[f][c].sigma;
      cells.push_back(sigma ? readable(sigma->max, shown_unit(coordinates[c].unit, a.spec.filters[f].filter))
                            : "-");
    }
  return cells;
}

std::string SweepTable::row(const SweptVariant& v) const {
  std::string row = std::to_string(v.variant);
  for (const std::string& name : grid_.names(v.variant)) row += next_cell + shown(name);
  const std::vector<std::string> own = v.check ? figures(*v.check) : std::vector<std::string>();
  // Variants may have other coordinates, filters or requirements than the spec: then figures are not
  // comparable.
  const std::size_t wanted = cells_.front().size() - 1 - grid_.keys().size();
  for (std::size_t i = 0; i < wanted; ++i) row += next_cell + (own.size() == wanted ? own[i] : "-");
  return row + next_row;
}

void SweepTable::add(const std::string& rows) {
  for (std::size_t begin = 0; begin < rows.size();) {
    std::vector<std::string>& cells = cells_.emplace_back();
    const std::size_t end = rows.find(next_row, begin);
    while (begin <= end) {
      const std::size_t stop = std::min(rows.find(next_cell, begin), end);
      cells.push_back(rows.substr(begin, stop - begin));
      begin = stop + 1;
    }
  }
}

std::string SweepTable::text(const Style& style) const {
  const Spec& spec = variants_.base();
  return changes_above(spec, style.width) + painted("qerr sweep", Paint::bold, style) + " robot '" +
         shown(spec.robot_name) + "', " + counted(grid_.count(), "variant") + "\n\n" +
         fitted_table(cells_, style.width) +
         wrapped("all figures: -o FILE.csv, or --wide for one row a variant", style.width, "  ");
}

}  // namespace qerr
