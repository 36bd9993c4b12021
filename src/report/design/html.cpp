#include <algorithm>
#include <cmath>

#include "report/analysis/about.hpp"
#include "report/design/table.hpp"
#include "report/formats.hpp"
#include "report/page/bars.hpp"
#include "report/page/markup.hpp"
#include "report/page/plot.hpp"
#include "report/page/prose.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

bool by_bits(const DesignReport& r) { return r.by_bits; }

std::string paragraph(const std::string& text) { return "<p>" + page::escaped_markup(text) + "</p>"; }

std::string encoder_table(const DesignReport& r, const Design& d) {
  if (d.encoders.empty()) return "";
  std::vector<std::vector<std::string>> rows;
  for (const DesignedEncoder& e : d.encoders)
    rows.push_back({e.joint, e.name, priced(e.price, r.price_unit), fixed_point(e.bits, 2)});
  page::Bars bars{by_bits(r) ? "Bits of each joint" : "Price of each joint",
                  "What each joint takes of the sum.",
                  {},
                  {"", by_bits(r) ? "bits" : r.price_unit, false, false}};
  for (const DesignedEncoder& e : d.encoders)
    if (by_bits(r) || e.price)
      bars.bars.push_back({e.joint + ": " + e.name, by_bits(r) ? e.bits : *e.price,
                           by_bits(r) ? bits_text(e.bits) : priced(e.price, r.price_unit)});
  const std::string rows_table = page::table({"joint", "encoder", "price", "bits at the joint"}, rows);
  return bars.bars.empty() ? rows_table : page::side_by_side("<div>" + rows_table + "</div>" + figure(bars));
}

std::string filter_paragraphs(const Design& d) {
  std::string out;
  for (const DesignedFilter& f : d.filters) {
    out += paragraph(filter_sentence(f));
    if (const std::string best = best_linear_sentence(f); !best.empty()) out += paragraph(best);
  }
  return out;
}

std::string chosen_section(const DesignReport& r, const Design& d) {
  std::string out = encoder_table(r, d) + filter_paragraphs(d);
  for (const std::string& text : gain_sentences(r, d)) out += paragraph(text);
  if (!d.encoders.empty())
    out += paragraph("Together " + (d.price ? priced(d.price, r.price_unit) + ", " : "") + bits_text(d.bits) +
                     '.');
  return out;
}

std::string margin_section(const DesignReport& r, const Design& d) {
  if (d.results.empty()) return "<p>The spec has no requirements.</p>";
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < d.results.size(); ++i) {
    const Requirement& q = r.spec.requirements[i];
    rows.push_back({q.name(), readable(d.results[i].value, q.unit),
                    std::string(q.at_least ? "at least " : "at most ") + readable(q.limit, q.unit),
                    margin_text(q, d.results[i]), d.results[i].met ? "met" : "NOT MET"});
  }
  const page::Bars bars = page::use_of_limits(r.spec.requirements, d.results);
  std::string out = (bars.bars.size() == 1 ? "" : figure(bars)) +
                    page::table({"requirement", "value", "limit", "margin", "verdict"}, rows);
  for (const std::size_t i : r.without_influence)
    out += "<p>No option changes " + page::name_markup(r.spec.requirements[i].name()) + ".</p>";
  return out;
}

bool same_encoders(const std::vector<DesignedEncoder>& a, const std::vector<DesignedEncoder>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const DesignedEncoder& x, const DesignedEncoder& y) { return x.name == y.name; });
}

/// The figure of the front for a design; empty if it is neither required nor that of a point of the front.
std::optional<double> front_value(const DesignReport& r, const Design& d) {
  for (const ParetoPoint& p : r.pareto)
    if (same_encoders(p.encoders, d.encoders) && d.filters.empty()) return p.value;
  for (std::size_t i = 0; i < d.results.size(); ++i)
    if (r.spec.requirements[i].name() == r.pareto_figure) return d.results[i].value;
  return std::nullopt;
}

/// The optimum and the runner-up beside the front; a design whose figure is not known is not drawn.
void mark_design(page::Plot& plot, const DesignReport& r, const std::string& name,
                 const std::optional<Design>& d) {
  if (!d) return;
  if (const auto value = front_value(r, *d))
    plot.series.push_back({name, {{by_bits(r) ? d->bits : d->price.value_or(0), *value}}, true, false});
}

std::string front_list(const DesignReport& r) {
  std::vector<std::vector<std::string>> rows;
  for (const ParetoPoint& p : r.pareto) {
    std::string encoders;
    for (const DesignedEncoder& e : p.encoders)
      encoders += (encoders.empty() ? "" : ", ") + page::isolated(e.joint) + ' ' + page::isolated(e.name);
    rows.push_back({encoders, by_bits(r) ? bits_text(p.bits) : priced(p.price, r.price_unit),
                    readable(p.value, r.pareto_unit), p.proven ? "yes" : "NO"});
  }
  return "<details><summary>Designs of the front</summary>" +
         page::table({"encoders", by_bits(r) ? "bits" : "price", r.pareto_figure, "proven"}, rows) +
         "</details>";
}

std::string front_section(const DesignReport& r) {
  if (r.pareto.empty())
    return "<p>No front: there are no encoders to choose, or only the optimum was asked for.</p>";
  page::Plot plot{(by_bits(r) ? "Bits against " : "Price against ") + r.pareto_figure,
                  "Designs that no cheaper one equals in this figure; the optimum and the runner-up are "
                  "marked.",
                  {by_bits(r) ? "bits of all joints" : "price", by_bits(r) ? "" : r.price_unit},
                  {page::shortened(r.pareto_figure, 46), r.pareto_unit},
                  {}};
  plot.x.prefix = false;  // 1.2 kEUR is no price
  page::Series front{"front", {}, true};
  for (const ParetoPoint& p : r.pareto)
    front.points.emplace_back(by_bits(r) ? p.bits : p.price.value_or(0), p.value);
  plot.series.push_back(front);
  mark_design(plot, r, "optimum", r.optimal);
  mark_design(plot, r, "runner-up", r.runner_up);
  return "<p>Each mark of the front is a design that no cheaper one equals in " +
         page::name_markup(r.pareto_figure) + "; the line between them guides the eye.</p>" + figure(plot) +
         front_list(r);
}

std::string price_section(const DesignReport& r) {
  const auto cost = [&](const RequirementPrice& p) { return by_bits(r) ? p.bits : p.price; };
  page::Bars bars{by_bits(r) ? "Bits with one requirement relaxed" : "Price with one requirement relaxed",
                  "The least that a design costs if the limit is looser by the part that is stated; the "
                  "first bar is the optimum.",
                  {},
                  {"", by_bits(r) ? "bits" : r.price_unit, false, false}};
  const Design& d = *r.optimal;
  const double optimum = by_bits(r) ? d.bits : d.price.value_or(0);
  bars.bars.push_back({"as required", optimum, cost_of(r, d.price, d.bits)});
  std::string none;
  for (const RequirementPrice& p : r.requirement_prices) {
    const std::string name = r.spec.requirements[p.requirement].name();
    if (const auto value = cost(p))
      bars.bars.push_back({name + ", " + percent(p.relaxed) + " looser", *value,
                           cost_of(r, p.price, p.bits.value_or(0)) + (p.proven ? "" : " or less")});
    else
      none += "<p>No price is known with " + page::name_markup(name) + " relaxed.</p>";
  }
  if (bars.bars.size() == 1) return none + "<p>No requirement has been relaxed.</p>";
  return figure(bars) + none;
}

std::string hindrances(const DesignReport& r) {
  if (r.obstacles.empty()) return "<p>Nothing single: it is the requirements together.</p>";
  std::string out = "<ul>";
  for (const std::string& text : r.obstacles) out += "<li>" + page::escaped_markup(text) + "</li>";
  return out + "</ul>";
}

page::Page infeasible_page(const DesignReport& r) {
  page::Page page{"Design of " + r.spec.robot_name,
                  r.proven ? "No design meets the requirements." : "No design was found.",
                  {{"What hinders", hindrances(r)}}};
  if (r.finest) {
    page.sections.push_back(
        {"Requirements with the design that is nearest to all limits", margin_section(r, *r.finest)});
    page.sections.push_back({"That design", chosen_section(r, *r.finest)});
  }
  return page;
}

page::Page feasible_page(const DesignReport& r) {
  const Design& d = *r.optimal;
  std::string answer = "The optimum is the " + optimum_sentence(r);
  if (r.budget) answer += "; the budget is " + priced(*r.budget, r.price_unit);
  return {"Design of " + r.spec.robot_name,
          answer + '.',
          {{"What to choose",
            chosen_section(r, d) + (r.runner_up ? paragraph("The " + runner_up_sentence(r) + '.') : "")},
           {"Requirements and their margins", margin_section(r, d)},
           {"What each requirement costs", price_section(r)},
           {"What each step of accuracy costs", front_section(r)}}};
}

}  // namespace

std::string to_html(const DesignReport& r, const Style&) {
  page::Page page = r.optimal ? feasible_page(r) : infeasible_page(r);
  page.warnings = r.warnings;
  describe(page, r.spec, r.optimal ? std::optional(r.optimal->results) : std::nullopt);
  return markup(page);
}

}  // namespace qerr
