#include <algorithm>
#include <cmath>

#include "report/design/sentences.hpp"
#include "report/fitted_table.hpp"
#include "report/formats.hpp"
#include "report/text_table.hpp"
#include "report/wrapped_text.hpp"

namespace qerr {

namespace {

std::string margin_text(const Requirement& r, const RequirementResult& result) {
  const std::optional<double> part = design_margin(r, result);
  return part ? percent(*part) : "";
}

std::string requirement_table(const DesignReport& report, const Design& d, const Style& style) {
  std::vector<std::vector<std::string>> rows{
      {"requirement", "value", "", "limit", "margin", "if 10 % looser"}};
  for (std::size_t i = 0; i < d.results.size(); ++i) {
    const Requirement& r = report.spec.requirements[i];
    std::string looser;
    for (const RequirementPrice& p : report.requirement_prices)
      if (p.requirement == i && p.bits)
        looser = cost_of(report, p.price, p.bits.value_or(0)) + (p.proven ? "" : " or less");
    const char* const relation =
        r.at_least ? (d.results[i].met ? ">=" : "<") : (d.results[i].met ? "<=" : ">");
    rows.push_back({shortened(r.quantity, 32) + (r.statistic.empty() ? "" : ' ' + r.statistic),
                    readable(d.results[i].value, r.unit), relation, readable(r.limit, r.unit),
                    d.results[i].met ? margin_text(r, d.results[i]) : "NOT MET", looser});
  }
  if (report.requirement_prices.empty())
    for (auto& row : rows) row.pop_back();
  return rows.size() > 1 ? fitted_table(rows, style.width) : "";
}

std::string choices(const DesignReport& report, const Design& d, const Style& style) {
  std::string out;
  if (!d.encoders.empty()) {
    std::vector<std::vector<std::string>> rows{{"joint", "encoder", "price", "bits at the joint"}};
    for (const DesignedEncoder& e : d.encoders)
      rows.push_back({shown(e.joint), shortened(e.name, 32), priced(e.price, report.price_unit),
                      fixed_point(e.bits, 2)});
    out += fitted_table(rows, style.width);
  }
  for (const DesignedFilter& f : d.filters) {
    out += wrapped(filter_sentence(f), style.width, "  ");
    const std::string best = best_linear_sentence(f);
    if (!best.empty()) out += wrapped(best, style.width, "    ");
  }
  return out;
}

std::string front_table(const DesignReport& report, const Style& style) {
  if (report.pareto.size() < 2) return "";
  const bool by_bits = report.by_bits;
  std::vector<std::vector<std::string>> rows{{by_bits ? "bits" : "price", report.pareto_figure}};
  for (const ParetoPoint& p : report.pareto)
    rows.push_back({by_bits ? fixed_point(p.bits, 2) : priced(p.price, report.price_unit),
                    readable(p.value, report.pareto_unit)});
  return heading((by_bits ? "Bits against " : "Price against ") + report.pareto_figure, style) +
         fitted_table(rows, style.width);
}

std::string infeasible(const DesignReport& report, const Style& style) {
  std::string out =
      painted(report.proven ? "no design meets the requirements" : "no design found", Paint::red, style) +
      '\n';
  for (const std::string& text : report.obstacles) out += wrapped(text, style.width, "  ");
  if (report.finest) {
    out += heading("Nearest to all limits", style) + choices(report, *report.finest, style) +
           requirement_table(report, *report.finest, style);
  }
  return out;
}

}  // namespace

std::string to_table(const DesignReport& report, const Style& style) {
  if (!report.optimal) return infeasible(report, style);
  std::string out =
      painted(optimum_sentence(report), report.proven ? Paint::bold : Paint::yellow, style) + '\n';
  out += choices(report, *report.optimal, style);
  const std::string requirements = requirement_table(report, *report.optimal, style);
  if (!requirements.empty()) out += '\n' + requirements;
  for (const std::size_t i : report.without_influence)
    out += wrapped("no option changes " + shown(report.spec.requirements[i].name()), style.width, "  ");
  if (report.runner_up) out += wrapped(runner_up_sentence(report), style.width);
  return out + front_table(report, style);
}

}  // namespace qerr
