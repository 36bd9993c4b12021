#include "report/analysis/figure_names.hpp"
#include "report/csv_text.hpp"
#include "report/json_header.hpp"
#include "report/output_schemas.hpp"
#include "report/sweep/sweep_report.hpp"

namespace qerr {

namespace {

Json figures(const Analysis& a, const std::vector<const StatisticKind*>& statistics) {
  Json list = Json::array();
  for_each_figure(a, [&](const FigureName& name, const Statistic& s) {
    Json figure{{"quantity", name.quantity()}, {"unit", name.unit}};
    for (const StatisticKind* kind : statistics) figure[kind->name] = s.*kind->value;
    list.push_back(std::move(figure));
  });
  return list;
}

Json filters(const Spec& spec) {
  Json list = Json::array();
  for (const NamedFilter& f : spec.filters) {
    Json filter{{"name", f.name}};
    for (const FilterFigure& figure : filter_figures()) filter[figure.name] = figure.value(f.filter, f.norms);
    list.push_back(std::move(filter));
  }
  return list;
}

Json requirements(const SpecCheck& check) {
  Json list = Json::array();
  for (std::size_t i = 0; i < check.results.size(); ++i) {
    const Requirement& r = check.analysis.spec.requirements[i];
    Json requirement{{"quantity", r.quantity}};
    if (!r.statistic.empty()) requirement["statistic"] = r.statistic;
    requirement[r.relation()] = r.limit;
    requirement["value"] = check.results[i].value;
    requirement["unit"] = r.unit;
    requirement["met"] = check.results[i].met;
    list.push_back(std::move(requirement));
  }
  return list;
}

}  // namespace

std::string SweepJson::variant(const SweptVariant& v, const SweepGrid& grid,
                               const std::vector<const StatisticKind*>& statistics) {
  Json values = Json::object();
  const std::vector<std::string> names = grid.names(v.variant);
  const std::vector<std::size_t> steps = grid.steps(v.variant);
  for (std::size_t k = 0; k < names.size(); ++k) {
    const SweepColumn& column = grid.columns()[k];
    if (column.values.empty())
      values[column.key] = names[k];
    else
      values[column.key] = column.values[steps[column.axis]];
  }
  Json j{{"variant", v.variant}, {"values", values}};
  if (!v.fault.empty()) j["error"] = v.fault;
  if (!v.check) return j.line();
  const Analysis& a = v.check->analysis;
  j["figures"] = figures(a, statistics);
  Json budget = Json::object();
  const std::vector<double> shares = encoder_budget(a);
  for (std::size_t i = 0; i < shares.size(); ++i) budget[a.spec.model.chain.independent[i].name] = shares[i];
  j["budget"] = budget;
  j["filters"] = filters(a.spec);
  j["requirements"] = requirements(*v.check);
  if (!v.check->results.empty()) j["met"] = v.check->all_met();
  return j.line();
}

SweepJson sweep_json(const SpecVariants& variants, const SweepGrid& grid) {
  const Spec& spec = variants.base();
  Json head = report_header(spec, "sweep", spec.configurations.seed);
  head["keys"] = grid.keys();
  Json units = Json::object();
  for (const SweepColumn& column : grid.columns())
    if (!column.unit.empty()) units[column.key] = column.unit;
  head["units"] = units;
  head["count"] = grid.count();
  std::string begin = head.document();
  begin.erase(begin.rfind('\n', begin.rfind('}')));
  return {begin + ",\n  \"variants\": [\n    ", ",\n    ", "\n  ]\n}\n"};
}

Json sweep_schema() {
  using namespace schema;
  std::vector<SchemaMember> figure{{"quantity", text(), "as requirements name it"}, {"unit", text()}};
  for (const StatisticKind& kind : statistic_kinds())
    figure.push_back({std::string(kind.name), number_or_null(), "", true});
  std::vector<SchemaMember> filter{{"name", text()}};
  for (const FilterFigure& f : filter_figures())
    filter.push_back({std::string(f.name), number_or_null(), std::string(f.summary) + ", in SI units"});
  const Json requirement = object({{"quantity", text()},
                                   {"statistic", text(), "none of a figure of a filter", true},
                                   {"at_most", number(), "", true},
                                   {"at_least", number(), "", true},
                                   {"value", number_or_null()},
                                   {"unit", text()},
                                   {"met", boolean()}});
  const Json variant =
      object({{"variant", number(), "its number, from 0"},
              {"values", map({{"type", Json::array({"number", "string"})}}),
               "of the keys that vary: numbers in SI units, or texts"},
              {"error", text(), "why it cannot be computed, or a requirement not decided", true},
              {"figures", list(object(figure)), "", true},
              {"budget", map(number()), "each encoder's share of the mean variance of the position", true},
              {"filters", list(object(filter)), "", true},
              {"requirements", list(requirement), "", true},
              {"met", boolean(), "whether all requirements are", true}});
  return object(joined(header("sweep"), {{"keys", list(text()), "what varies; the first one slowest"},
                                         {"units", map(text()), "of the keys whose values have one"},
                                         {"count", number(), "of the variants"},
                                         {"variants", list(variant)}}));
}

}  // namespace qerr
