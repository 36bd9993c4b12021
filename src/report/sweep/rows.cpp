#include <algorithm>
#include <map>
#include <memory>

#include "core/text.hpp"
#include "qerr/filter/norms.hpp"
#include "report/analysis/effects.hpp"
#include "report/analysis/figures.hpp"
#include "report/analysis/tables.hpp"
#include "report/formats.hpp"
#include "report/sweep/sweep.hpp"

namespace qerr {

namespace {

using Statistics = std::vector<const StatisticKind*>;

struct ReportedVariant {
  const SweptVariant& swept;
  const SweepGrid& grid;
  const Statistics& statistics;
};
using SweptFilter = In<NamedFilter, ReportedVariant>;
using SweptResult = In<RequirementResult, ReportedVariant>;

/// The values of the keys that vary, by key.
std::vector<std::pair<std::string, Json>> values(const ReportedVariant& v) {
  std::vector<std::pair<std::string, Json>> all;
  const std::vector<std::string> names = v.grid.names(v.swept.variant);
  const std::vector<std::size_t> steps = v.grid.steps(v.swept.variant);
  for (const SweepColumn& column : v.grid.columns())
    all.emplace_back(column.key, column.values.empty() ? Json(names[all.size()])
                                                       : Json(column.values[steps[column.axis]]));
  return all;
}

/// The number of a variant and the values of its keys, numbers in SI units: the cells at the begin of its
/// lines, with their commas; and the header of these cells.
std::string cells_of_variant(const SweepGrid& grid, std::uint64_t variant) {
  std::string cells = std::to_string(variant) + ',';
  const std::vector<std::size_t> steps = grid.steps(variant);
  const std::vector<std::string> names = grid.names(variant);
  for (std::size_t k = 0; k < names.size(); ++k) {
    const SweepColumn& column = grid.columns()[k];
    cells +=
        (column.values.empty() ? csv_cell(names[k]) : csv_number(column.values[steps[column.axis]])) + ',';
  }
  return cells;
}

/// The number of a variant and the values of its keys, numbers in SI units: the cells at the begin of its
/// lines, with their commas; and the header of these cells.
std::string header_of_variants(const SweepGrid& grid) {
  std::string header = "variant,";
  for (const SweepColumn& column : grid.columns()) header += csv_cell(column.header()) + ',';
  return header;
}

/// A cell of a variant's row, with the header of its column.
struct WideCell {
  std::string column, text;
};

std::string with_unit(const std::string& name, const std::string& unit) {
  return unit.empty() ? name : name + " [" + unit + ']';
}

void add_filter_figures(const Spec& spec, std::vector<WideCell>& cells) {
  for (const NamedFilter& f : spec.filters)
    for (const FilterFigure& figure : filter_figures())
      cells.push_back({with_unit(f.name + '.' + std::string(figure.name), figure_unit(figure, f.filter)),
                       csv_number(figure.value(f.filter, f.norms))});
}

/// @param results  one for each requirement, or none
void add_requirements(const Spec& spec, const std::vector<RequirementResult>& results,
                      std::vector<WideCell>& cells) {
  bool all_met = true;
  const auto verdict = [&](bool met) { return results.empty() ? "" : met ? "true" : "false"; };
  for (std::size_t i = 0; i < spec.requirements.size(); ++i) {
    const RequirementResult result = results.empty() ? RequirementResult{} : results[i];
    const std::string name = "requirements[" + std::to_string(i) + "].";
    cells.push_back({with_unit(name + "value", spec.requirements[i].unit),
                     results.empty() ? "" : csv_number(result.value)});
    cells.push_back({name + "met", verdict(result.met)});
    all_met = all_met && result.met;
  }
  if (!spec.requirements.empty()) cells.push_back({"met", verdict(all_met)});
}

/// The row of a variant that was computed.
std::vector<WideCell> cells_of(const SpecCheck& check, const std::vector<const StatisticKind*>& statistics) {
  std::vector<WideCell> cells;
  const Analysis& a = check.analysis;
  for_each_figure(a, [&](const FigureName& name, const Statistic& s) {
    const std::string quantity = name.quantity();
    for (const StatisticKind* kind : statistics)
      cells.push_back(
          {with_unit(quantity + '.' + std::string(kind->name), name.unit), csv_number(s.*kind->value)});
  });
  const std::vector<double> budget = encoder_budget(a);
  for (std::size_t i = 0; i < budget.size(); ++i)
    cells.push_back({"budget." + a.spec.model.chain.independent[i].name + ".share", csv_number(budget[i])});
  for (const SingleFigure& f : single_figures(a))
    cells.push_back({with_unit(f.quantity, f.unit), csv_number(f.value)});
  add_filter_figures(a.spec, cells);
  add_requirements(a.spec, check.results, cells);
  return cells;
}

class WideColumns {
 public:
  WideColumns(const SweepGrid& grid, const SpecVariants& variants,
              const std::vector<const StatisticKind*>& statistics) {
    std::vector<std::size_t> steps(grid.axes().size());
    Attempt first{grid, variants, statistics};
    // Where the first variant cannot be read, the spec itself says what the columns are.
    if (const auto cells = first(steps))
      add(*cells);
    else
      add(first.of_base());
    for (std::size_t a = 0; a < steps.size(); ++a) {
      for (steps[a] = 1; steps[a] < grid.axes()[a].steps.size(); ++steps[a])
        if (const auto cells = first(steps)) add(*cells);
      steps[a] = 0;
    }
  }

  const std::vector<std::string>& names() const { return names_; }

  std::size_t index(const std::string& name, const SweepGrid& grid, std::uint64_t variant) const {
    const auto found = index_.find(name);
    if (found != index_.end()) return found->second;
    throw Error("sweep",
                "variant " + std::to_string(variant) + " has a figure that no variant with one change has",
                quoted(name) + " where " + grid.description(variant),
                "leave out --wide: a row for each figure has room for it");
  }

 private:
  /// The cells of a variant, of which only the columns count: with one configuration.
  struct Attempt {
    const SweepGrid& grid;
    const SpecVariants& variants;
    const std::vector<const StatisticKind*>& statistics;

    std::optional<std::vector<WideCell>> operator()(const std::vector<std::size_t>& steps) const {
      try {
        return columns(grid.spec(variants, steps));
      } catch (const Error& e) {
        if (e.trouble() != Trouble::input) throw;
        return std::nullopt;
      }
    }
    std::vector<WideCell> of_base() const { return columns(variants.base()); }

    std::vector<WideCell> columns(Spec spec) const {
      Configurations& c = spec.configurations;
      c = {.method = SamplingMethod::random, .count = 1, .seed = c.seed, .ranges = c.ranges};
      WorkspaceOptions options;
      options.threads = 1;
      return cells_of({analysis_without_warnings(spec, effect_report(spec), options), {}}, statistics);
    }
  };

  void add(const std::vector<WideCell>& cells) {
    std::size_t after = 0;  // a new column follows the one that precedes it in its variant
    for (const WideCell& cell : cells) {
      const auto found = std::ranges::find(names_, cell.column);
      if (found == names_.end())
        names_.insert(names_.begin() + (after++), cell.column);
      else
        after = static_cast<std::size_t>(found - names_.begin()) + 1;
    }
    index_.clear();
    for (std::size_t i = 0; i < names_.size(); ++i) index_[names_[i]] = i;
  }

  std::vector<std::string> names_;
  std::map<std::string, std::size_t> index_;
};

/// A getter of the analysis of a variant: empty if it cannot be computed.
template <class Getter>
auto analyzed(Getter getter) {
  return [getter](const ReportedVariant& v) {
    return v.swept.check ? std::optional(getter(v.swept.check->analysis)) : std::nullopt;
  };
}

struct SweptFigure {
  std::string quantity, unit;
  Statistic statistic;
  const Statistics& asked;
};

std::optional<std::vector<SweptFigure>> figures(const ReportedVariant& v) {
  if (!v.swept.check) return {};
  std::vector<SweptFigure> all;
  for_each_figure(v.swept.check->analysis, [&](const FigureName& name, const Statistic& s) {
    all.push_back({name.quantity(), name.unit, s, v.statistics});
  });
  return all;
}

struct SweepHead {
  const Spec& spec;
  const SweepGrid& grid;
};

auto units(const SweepHead& h) {
  std::vector<SweepColumn> columns = h.grid.columns();
  std::erase_if(columns, [](const SweepColumn& c) { return c.unit.empty(); });
  return by_name(columns, &SweepColumn::key, &SweepColumn::unit);
}

std::vector<std::string> headers(const Spec& spec) {
  std::vector<std::string> headers;
  if (!spec.requirements.empty()) {
    for (const Requirement& r : spec.requirements) headers.push_back(shown(in_words(r.name())));
    headers.emplace_back("met");
    return headers;
  }
  const std::vector<Signal> coordinates = all_signals(spec.model);
  for (const Signal& c : coordinates) headers.push_back(c.name + " worst max");
  for (const NamedFilter& f : spec.filters)
    for (const Signal& c : coordinates)
      if (is_filtered(f, c)) headers.push_back(shown(in_words(f.name)) + ' ' + c.name + " sigma max");
  return headers;
}

}  // namespace

SweepRows tidy_rows(const SweepGrid& grid, std::vector<const StatisticKind*> statistics) {
  SweepRows rows{header_of_variants(grid) + std::string(analysis_csv_header), {}};
  rows.lines = [&grid, statistics = std::move(statistics)](const SweptVariant& v) {
    const std::string cells = cells_of_variant(grid, v.variant);
    if (!v.check) return cells + "error,,,," + csv_cell(v.fault) + ",,\r\n";
    return analysis_csv_rows(v.check->analysis, cells, statistics);
  };
  return rows;
}

SweepRows wide_rows(const SweepGrid& grid, const SpecVariants& variants,
                    std::vector<const StatisticKind*> statistics) {
  const auto columns = std::make_shared<const WideColumns>(grid, variants, statistics);
  SweepRows rows{header_of_variants(grid), {}};
  for (const std::string& name : columns->names()) rows.header += csv_cell(name) + ',';
  rows.header += "error";
  rows.lines = [&grid, columns, statistics = std::move(statistics)](const SweptVariant& v) {
    std::vector<std::string> cells(columns->names().size());
    if (v.check)
      for (WideCell& cell : cells_of(*v.check, statistics))
        cells[columns->index(cell.column, grid, v.variant)] = std::move(cell.text);
    std::string line = cells_of_variant(grid, v.variant);
    for (const std::string& cell : cells) line += cell + ',';
    return line + csv_cell(v.fault) + "\r\n";
  };
  return rows;
}

RowsOf<SweptFigure> rows(Of<SweptFigure>) {
  RowsOf<SweptFigure> all{{"quantity", &SweptFigure::quantity, "as requirements name it"},
                          {"unit", &SweptFigure::unit}};
  for (const StatisticKind& kind : statistic_kinds())
    all = all.with({{kind.name,
                     [&kind](auto& f) {
                       const bool asked = std::ranges::count(f.asked, &kind) > 0;
                       return only_if(asked, std::optional(f.statistic.*kind.value));
                     },
                     optional}});
  return all;
}

RowsOf<SweptFilter> rows(Of<SweptFilter>) {
  RowsOf<SweptFilter> all{{"name", &NamedFilter::name}};
  for (const FilterFigure& figure : filter_figures())
    all = all.with({{figure.name, [&figure](auto& f) { return figure.value(f->filter, f->norms); },
                     std::string(figure.summary) + ", in SI units"}});
  return all;
}

RowsOf<SweptResult> rows(Of<SweptResult>) {
  return requirement_rows<SweptResult>(
      [](auto& r) -> auto& { return r.whole.swept.check->analysis.spec.requirements[r.i]; },
      "none of a figure of a filter", "", "");
}

RowsOf<ReportedVariant> rows(Of<ReportedVariant>) {
  return {{"variant", [](auto& v) { return v.swept.variant; }, "its number, from 0"},
          {"values", values, Schema{schema::map({{"type", Json::array({"number", "string"})}})},
           "of the keys that vary: numbers in SI units, or texts"},
          {"error", [](auto& v) { return v.swept.fault; },
           "why it cannot be computed, or a requirement not decided", optional},
          {"figures", figures, optional},
          {"budget", analyzed(budget), "each encoder's share of the mean variance of the position", optional},
          {"filters", within(analyzed([](auto& a) { return a.spec.filters; })), optional},
          {"requirements", within([](auto& v) {
             return v.swept.check ? std::optional(v.swept.check->results) : std::nullopt;
           }),
           optional},
          {"met",
           [](auto& v) {
             const bool judged = v.swept.check && !v.swept.check->results.empty();
             return judged ? std::optional(v.swept.check->all_met()) : std::nullopt;
           },
           "whether all requirements are", optional}};
}

RowsOf<SweepHead> rows(Of<SweepHead>) {
  return spec_header<SweepHead>("sweep").with(
      {{"keys", [](auto& h) { return h.grid.keys(); }, "what varies; the first one slowest"},
       {"units", units, "of the keys whose values have one"},
       {"count", [](auto& h) { return h.grid.count(); }, "of the variants"},
       {"variants", [](auto&) { return std::vector<ReportedVariant>(); }}});  // written one after the other
}

std::string SweepJson::variant(const SweptVariant& v, const SweepGrid& grid, const Statistics& statistics) {
  return line(json_of(ReportedVariant{v, grid, statistics}));
}

SweepJson sweep_json(const SpecVariants& variants, const SweepGrid& grid) {
  const std::string whole = document(json_of(SweepHead{variants.base(), grid}));
  return {whole.substr(0, whole.rfind(']')) + "\n    ", ",\n    ", "\n  ]\n}\n"};
}

Json sweep_schema() { return schema_of<SweepHead>(); }

std::string in_words(std::string path) {
  std::ranges::replace(path, '.', ' ');
  return path;
}

SweepTable::SweepTable(const SpecVariants& variants, const SweepGrid& grid)
    : variants_(variants), grid_(grid) {
  std::vector<std::string>& header = cells_.emplace_back();
  header.emplace_back("variant");
  for (const std::string& key : grid.keys()) header.push_back(shown(in_words(key)));
  append(header, headers(variants.base()));
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

std::vector<std::string> SweepTable::row(const SweptVariant& v) const {
  std::vector<std::string> row{std::to_string(v.variant)};
  for (const std::string& name : grid_.names(v.variant)) row.push_back(shown(name));
  std::vector<std::string> own = v.check ? figures(*v.check) : std::vector<std::string>();
  // Variants may have other coordinates, filters or requirements than the spec: then figures are not
  // comparable.
  const std::size_t wanted = cells_.front().size() - 1 - grid_.keys().size();
  append(row, own.size() == wanted ? std::move(own) : std::vector<std::string>(wanted, "-"));
  return row;
}

std::string SweepTable::text(const Style& style) const {
  const Spec& spec = variants_.base();
  return changes_above(spec, style.width) + painted("qerr sweep", Paint::bold, style) + " robot '" +
         shown(spec.robot_name) + "', " + counted(grid_.count(), "variant") + "\n\n" +
         fitted_table(cells_, style.width) +
         wrapped("all figures: -o FILE.csv, or --wide for one row a variant", style.width, "  ");
}

}  // namespace qerr
