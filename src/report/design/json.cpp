#include "report/formats.hpp"
#include "report/json_header.hpp"
#include "report/json_value.hpp"

namespace qerr {

namespace {

Json encoders_json(const std::vector<DesignedEncoder>& encoders) {
  Json names = Json::object();
  for (const DesignedEncoder& e : encoders) names[e.joint] = e.name;
  return names;
}

Json filter_json(const DesignedFilter& f) {
  Json j = {{"family", f.family},
            {"order", f.order},
            {"cutoff", f.cutoff},
            {"h2_norm", f.filter.norms.h2},
            {"l1_norm", f.filter.norms.l1.upper},
            {"delay", f.delay},
            {"tracking_error", f.tracking}};
  if (!f.best_linear) {
    j["best_linear"] = nullptr;
    return j;
  }
  j["best_linear"] = {{"taps", f.best_linear->taps},
                      {"h2_norm", f.best_linear->h2},
                      {"h2_norm_bound", f.best_linear->h2_bound},
                      {"ratio", f.filter.norms.h2 / f.best_linear->h2}};
  return j;
}

Json design_json(const DesignReport& report, const std::optional<Design>& d) {
  if (!d) return nullptr;
  Json filters = Json::object(), requirements = Json::array();
  for (const DesignedFilter& f : d->filters) filters[f.name] = filter_json(f);
  for (std::size_t i = 0; i < d->results.size(); ++i) {
    const Requirement& r = report.spec.requirements[i];
    Json row = {{"quantity", r.quantity}};
    if (r.limits_error()) row["statistic"] = r.statistic;
    row[std::string(r.relation())] = r.limit;
    row["value"] = d->results[i].value;
    row["unit"] = r.unit;
    row["met"] = d->results[i].met;
    requirements.push_back(row);
  }
  Json set = Json::array();
  for (const std::string& change : d->changes_by_set) set.push_back(change);
  Json j = {{"price", d->price}, {"bits", d->bits}};
  if (d->minimized) j["value"] = *d->minimized;
  j["encoders"] = encoders_json(d->encoders);
  j["filters"] = filters;
  j["requirements"] = requirements;
  j["set"] = set;
  return j;
}

}  // namespace

std::string to_json(const DesignReport& report, const Style&) {
  Json j = report_header(report.spec, "design", report.spec.configurations.seed);
  j["minimize"] = report.goal;
  j["price_unit"] = report.price_unit;
  if (report.budget) j["budget"] = *report.budget;
  j["optimal"] = design_json(report, report.optimal);
  j["runner_up"] = design_json(report, report.runner_up);
  j["proven"] = report.proven;
  j["bound"] = report.bound;
  Json prices = Json::array(), front = Json::array();
  for (const RequirementPrice& p : report.requirement_prices)
    prices.push_back({{"requirement", p.requirement},
                      {"relaxed", p.relaxed},
                      {"price", p.price},
                      {"bits", p.bits},
                      {"proven", p.proven}});
  for (const ParetoPoint& p : report.pareto)
    front.push_back({{"price", p.price},
                     {"bits", p.bits},
                     {"quantity", report.pareto_figure},
                     {"value", p.value},
                     {"unit", report.pareto_unit},
                     {"encoders", encoders_json(p.encoders)},
                     {"proven", p.proven}});
  j["price_of_requirements"] = prices;
  j["pareto"] = front;
  j["finest"] = design_json(report, report.finest);
  j["obstacles"] = report.obstacles;
  j["left_out"] = report.left_out;
  Json idle = Json::array();
  for (const std::size_t i : report.without_influence) idle.push_back(i);
  j["without_influence"] = idle;
  j["warnings"] = report.warnings;
  return j.document();
}

}  // namespace qerr
