#include <algorithm>

#include "report/analysis/figure_names.hpp"
#include "report/analysis/json_header.hpp"
#include "report/csv_text.hpp"
#include "report/sweep/run_sweep.hpp"

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

}  // namespace

RowsOf<SweptFigure> rows(Of<SweptFigure>) {
  RowsOf<SweptFigure> all{{"quantity", &SweptFigure::quantity, "as requirements name it"},
                          {"unit", &SweptFigure::unit}};
  for (const StatisticKind& kind : statistic_kinds())
    all = all.with({{kind.name,
                     [&kind](auto& f) {
                       const bool asked = std::count(f.asked.begin(), f.asked.end(), &kind) > 0;
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
  return json_of(ReportedVariant{v, grid, statistics}).line();
}

SweepJson sweep_json(const SpecVariants& variants, const SweepGrid& grid) {
  const std::string document = json_of(SweepHead{variants.base(), grid}).document();
  return {document.substr(0, document.rfind(']')) + "\n    ", ",\n    ", "\n  ]\n}\n"};
}

Json sweep_schema() { return schema_of<SweepHead>(); }

}  // namespace qerr
