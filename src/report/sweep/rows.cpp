#include "report/sweep/rows.hpp"

#include <algorithm>
#include <map>
#include <memory>

#include "core/text.hpp"
#include "qerr/filter/norms.hpp"
#include "report/analysis/effects.hpp"
#include "report/analysis/figure_names.hpp"
#include "report/csv_text.hpp"

namespace qerr {

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

std::string header_of_variants(const SweepGrid& grid) {
  std::string header = "variant,";
  for (const SweepColumn& column : grid.columns()) header += csv_cell(column.header()) + ',';
  return header;
}

SweepRows tidy_rows(const SweepGrid& grid, std::vector<const StatisticKind*> statistics) {
  SweepRows rows{header_of_variants(grid) + std::string(analysis_csv_header), {}};
  rows.lines = [&grid, statistics = std::move(statistics)](const SweptVariant& v) {
    const std::string cells = cells_of_variant(grid, v.variant);
    if (!v.check) return cells + "error,,,," + csv_cell(v.fault) + ",,\r\n";
    return analysis_csv_rows(v.check->analysis, cells, statistics);
  };
  return rows;
}

namespace {

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

/// Columns in the order in which variants bring them.
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
    throw Error({{},
                 "sweep",
                 "variant " + std::to_string(variant) + " has a figure that no variant with one change has",
                 quoted(name) + " where " + grid.description(variant),
                 "leave out --wide: a row for each figure has room for it"});
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
      const auto found = std::find(names_.begin(), names_.end(), cell.column);
      if (found == names_.end())
        names_.insert(names_.begin() + static_cast<std::ptrdiff_t>(after++), cell.column);
      else
        after = static_cast<std::size_t>(found - names_.begin()) + 1;
    }
    index_.clear();
    for (std::size_t i = 0; i < names_.size(); ++i) index_[names_[i]] = i;
  }

  std::vector<std::string> names_;
  std::map<std::string, std::size_t> index_;
};

}  // namespace

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

}  // namespace qerr
