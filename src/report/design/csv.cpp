#include "report/csv_text.hpp"
#include "report/formats.hpp"

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

}  // namespace qerr
