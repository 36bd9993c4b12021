#include <map>
#include <string>

#include "qerr/report/design_report.hpp"
#include "report/csv_text.hpp"
#include "report/formats.hpp"
#include "report/json_header.hpp"

namespace qerr {

namespace {

std::string row(const std::string& design, const std::string& what, const std::string& name,
                const std::string& value, const std::string& unit) {
  return design + ',' + what + ',' + csv_cell(name) + ',' + csv_cell(value) + ',' + csv_cell(unit) + "\r\n";
}

std::string rows_of(const DesignReport& report, const std::string& name, const std::optional<Design>& d) {
  if (!d) return "";
  std::string out = row(name, "price", "", csv_number(d->price), report.price_unit);
  out += row(name, "bits", "", csv_number(d->bits), "");
  if (d->minimized) out += row(name, "minimized", report.goal, csv_number(*d->minimized), report.goal_unit);
  for (const DesignedEncoder& e : d->encoders) out += row(name, "encoder", e.joint, e.name, "");
  for (const DesignedFilter& f : d->filters) {
    out += row(name, "filter.family", f.name, f.family, "");
    out += row(name, "filter.order", f.name, std::to_string(f.order), "");
    out += row(name, "filter.cutoff", f.name, csv_number(f.cutoff), "Hz");
  }
  for (const DesignedGain& g : d->gains) out += row(name, g.key, g.joint, csv_number(g.value), "");
  for (std::size_t i = 0; i < d->results.size(); ++i)
    out += row(name, "requirement", report.spec.requirements[i].name(), csv_number(d->results[i].value),
               report.spec.requirements[i].unit);
  return out;
}

}  // namespace

std::string to_csv(const DesignReport& report, const Style&) {
  std::string out = "design,what,name,value,unit\r\n";
  out += rows_of(report, "optimal", report.optimal);
  out += rows_of(report, "runner_up", report.runner_up);
  out += rows_of(report, "finest", report.finest);
  for (const RequirementPrice& p : report.requirement_prices)
    out += row("relaxed", "price", report.spec.requirements[p.requirement].name(),
               p.price ? csv_number(*p.price) : "", report.price_unit);
  for (std::size_t i = 0; i < report.pareto.size(); ++i) {
    const std::string name = "pareto." + std::to_string(i);
    out += row(name, "price", "", csv_number(report.pareto[i].price), report.price_unit);
    out += row(name, "bits", "", csv_number(report.pareto[i].bits), "");
    out += row(name, "figure", report.pareto_figure, csv_number(report.pareto[i].value), report.pareto_unit);
    for (const DesignedEncoder& e : report.pareto[i].encoders)
      out += row(name, "encoder", e.joint, e.name, "");
  }
  return out;
}

namespace {

using ReportedDesign = In<Design, DesignReport>;
using ReportedRequirement = In<RequirementResult, ReportedDesign>;
using Best = DesignedFilter::BestLinear;

/// The name of the option by joint.
std::map<std::string, std::map<std::string, double>> gains_by_joint(const Design& d) {
  std::map<std::string, std::map<std::string, double>> all;
  for (const DesignedGain& g : d.gains) all[g.joint][g.key] = g.value;
  return all;
}

auto option_names(const std::vector<DesignedEncoder>& encoders) {
  return by_name(encoders, &DesignedEncoder::joint, &DesignedEncoder::name);
}

}  // namespace

RowsOf<In<Best, DesignedFilter>> rows(Of<In<Best, DesignedFilter>>) {
  return {{"taps", &Best::taps, "of the filters compared with"},
          {"h2_norm", &Best::h2, "of the quietest one found"},
          {"h2_norm_bound", &Best::h2_bound, "none with as many taps falls below"},
          {"ratio", [](auto& b) { return b.whole.filter.norms.h2 / b->h2; },
           "of the chosen filter's norm to it"}};
}

RowsOf<DesignedFilter> rows(Of<DesignedFilter>) {
  return {
      {"family", &DesignedFilter::family},
      {"order", &DesignedFilter::order},
      {"cutoff", &DesignedFilter::cutoff, "Hz"},
      {"h2_norm", [](auto& f) { return f.filter.norms.h2; }},
      {"l1_norm", [](auto& f) { return f.filter.norms.l1.upper; }},
      {"delay", &DesignedFilter::delay, "at 0 Hz, s"},
      {"tracking_error", &DesignedFilter::tracking, "largest up to the band's end; null: no band is stated"},
      {"best_linear", within(&DesignedFilter::best_linear),
       "the quietest filter of that tracking error; null: no band"}};
}

RowsOf<ReportedRequirement> rows(Of<ReportedRequirement>) {
  return requirement_rows<ReportedRequirement>(
      [](auto& r) -> auto& { return r.whole.whole.spec.requirements[r.i]; }, "not of a figure of a filter",
      "", "null: unbounded");
}

RowsOf<ReportedDesign> rows(Of<ReportedDesign>) {
  return {{"price", &Design::price, "of all encoders; null: not stated of one"},
          {"bits", &Design::bits,
           "sum over the joints of the binary logarithm of the intervals in a turn, or in 1 m"},
          {"value", &Design::minimized, Schema{schema::or_null(schema::number())},
           "of the quantity that is minimized", optional},
          {"encoders", [](auto& d) { return option_names(d->encoders); }, "name of the option by joint"},
          {"filters", [](auto& d) { return by_name(d->filters, &DesignedFilter::name, std::identity()); },
           "by name"},
          {"gains", [](auto& d) { return gains_by_joint(*d); }, "by joint: kp, kd [SI]", optional},
          {"requirements", within(&Design::results)},
          {"set", &Design::changes_by_set,
           "KEY=VALUE for --set: encoders and filters of the choice; effects of catalogue rows are only in "
           "what --write-spec writes"}};
}

RowsOf<RequirementPrice> rows(Of<RequirementPrice>) {
  return {{"requirement", &RequirementPrice::requirement, "its index in the spec"},
          {"relaxed", &RequirementPrice::relaxed, "part of the limit by which it is looser"},
          {"price", &RequirementPrice::price, "then; null: none is found, or not stated"},
          {"bits", &RequirementPrice::bits},
          {"proven", &RequirementPrice::proven}};
}

RowsOf<In<ParetoPoint, DesignReport>> rows(Of<In<ParetoPoint, DesignReport>>) {
  return {{"price", &ParetoPoint::price},
          {"bits", &ParetoPoint::bits, "sum over the joints"},
          {"quantity", [](auto& p) { return p.whole.pareto_figure; }},
          {"value", &ParetoPoint::value, nullable},
          {"unit", [](auto& p) { return p.whole.pareto_unit; }},
          {"encoders", [](auto& p) { return option_names(p->encoders); }},
          {"proven", &ParetoPoint::proven}};
}

RowsOf<DesignReport> rows(Of<DesignReport>) {
  using Report = DesignReport;
  return spec_header<Report>("design").with(
      {{"minimize", &Report::goal, "price, resolution, or a quantity"},
       {"price_unit", &Report::price_unit, "of the catalogues; empty: not stated"},
       {"budget", &Report::budget, optional},
       {"optimal", within(&Report::optimal), "null: no design meets the requirements"},
       {"runner_up", within(&Report::runner_up)},
       {"proven", &Report::proven, "whether no better design exists"},
       {"bound", &Report::bound, "of the price (bits), if it is not proven"},
       {"price_of_requirements", &Report::requirement_prices},
       {"pareto", within(&Report::pareto),
        "by ascending price; minimize: resolution, or a price is missing: by bits"},
       {"uniform", within(&Report::uniform),
        "one option at all joints to choose for, in the figure of the front"},
       {"finest", within(&Report::finest), "nothing feasible: the design nearest to all limits"},
       {"obstacles", &Report::obstacles, "nothing feasible: why"},
       {"left_out", &Report::left_out, "options that cannot count fast enough"},
       {"without_influence", &Report::without_influence, "requirements that no option changes"},
       {"warnings", &Report::warnings}});
}

}  // namespace qerr
