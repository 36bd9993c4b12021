#include <algorithm>

#include "report/analysis/about.hpp"
#include "report/design/table.hpp"
#include "report/formats.hpp"
#include "report/page/markup.hpp"
#include "report/page/page.hpp"
#include "report/page/plot.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

/// The bits or the price of a design, of a point of the front or of an encoder.
template <class Priced>
double cost(const DesignReport& r, const Priced& of) {
  return r.by_bits ? of.bits : of.price.value_or(0);
}

/// Each joint's encoder with what it takes of the sum.
std::string encoder_table(const DesignReport& r, const Design& d) {
  if (d.encoders.empty()) return "";
  double largest = 0;
  for (const DesignedEncoder& e : d.encoders) largest = std::max(largest, cost(r, e));
  std::vector<std::string> rows;
  for (const DesignedEncoder& e : d.encoders) {
    const auto paid = [&](const std::string& text, bool counts) {
      return counts && largest > 0 ? page::bar_cell(text, cost(r, e) / largest, cost(r, e))
                                   : page::cell(text);
    };
    rows.push_back(page::cell(e.joint) + page::cell(e.name) + paid(fixed_point(e.bits, 2), r.by_bits) +
                   paid(priced(e.price, r.price_unit), !r.by_bits));
  }
  return page::table_of("pays", {"joint", "encoder", "bits at the joint", "price"}, rows);
}

std::string filter_paragraphs(const Design& d) {
  std::string out;
  for (const DesignedFilter& f : d.filters) {
    out += page::paragraph(filter_sentence(f));
    if (const std::string best = best_linear_sentence(f); !best.empty()) out += page::paragraph(best);
  }
  return out;
}

std::string chosen_section(const DesignReport& r, const Design& d) {
  std::string out = encoder_table(r, d) + filter_paragraphs(d);
  for (const std::string& text : gain_sentences(r, d)) out += page::paragraph(text);
  if (!d.encoders.empty())
    out += page::paragraph("Together " + (d.price ? priced(d.price, r.price_unit) + ", " : "") +
                           bits_text(d.bits) + '.');
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
    plot.series.push_back({name, {{cost(r, *d), *value}}, true, false});
}

std::string front_list(const DesignReport& r) {
  TableRows rows;
  for (const ParetoPoint& p : r.pareto) {
    rows.push_back({joined(p.encoders, ", ",
                           [](const DesignedEncoder& e) {
                             return page::isolated(e.joint) + ' ' + page::isolated(e.name);
                           }),
                    cost_of(r, p.price, p.bits), readable(p.value, r.pareto_unit), p.proven ? "yes" : "NO"});
  }
  return "<details><summary>Designs of the front</summary>" +
         page::table({"encoders", r.by_bits ? "bits" : "price", r.pareto_figure, "proven"}, rows) +
         "</details>";
}

/// The cheapest design of the front beyond the optimum, and what it changes; "" if there is none.
std::string next_step(const DesignReport& r) {
  const Design& d = *r.optimal;
  const auto now = front_value(r, d);
  for (const ParetoPoint& p : r.pareto) {
    const double more = cost(r, p) - cost(r, d);
    if (!(more > 0) || (now && p.value >= *now)) continue;
    std::vector<std::string> changes;
    for (std::size_t i = 0; i < std::min(p.encoders.size(), d.encoders.size()); ++i)
      if (p.encoders[i].name != d.encoders[i].name)
        changes.push_back(page::isolated(p.encoders[i].joint) + ' ' + page::isolated(p.encoders[i].name));
    return "The next better step costs " + cost_of(r, more, more) + " more" +
           (changes.empty() ? "" : " with " + joined(changes)) + ": " + page::isolated(r.pareto_figure) +
           ' ' + readable(p.value, r.pareto_unit) +
           (now ? " in place of " + readable(*now, r.pareto_unit) : "") + '.';
  }
  return "";
}

std::string front_section(const DesignReport& r) {
  if (r.pareto.empty())
    return "<p>No front: there are no encoders to choose, or only the optimum was asked for.</p>";
  page::Plot plot{(r.by_bits ? "Bits against " : "Price against ") + r.pareto_figure,
                  "Designs that no cheaper one equals in this figure; the optimum and the runner-up are "
                  "marked.",
                  {r.by_bits ? "bits of all joints" : "price", r.by_bits ? "" : r.price_unit},
                  {page::shortened(r.pareto_figure, 46), r.pareto_unit},
                  {}};
  plot.x.prefix = false;  // 1.2 kEUR is no price
  page::Series front{"front", {}, true};
  for (const ParetoPoint& p : r.pareto) front.points.emplace_back(cost(r, p), p.value);
  plot.series.push_back(front);
  // Rows far beyond the front would squeeze it.
  page::Series rows{"one encoder at all joints", {}, true, false};
  for (const ParetoPoint& p : r.uniform)
    if (p.value <= r.pareto.front().value && p.value > 0) rows.points.emplace_back(cost(r, p), p.value);
  if (!rows.points.empty()) plot.series.push_back(std::move(rows));
  mark_design(plot, r, "optimum", r.optimal);
  mark_design(plot, r, "runner-up", r.runner_up);
  return "<p>Each mark of the front is a design that no cheaper one equals in " +
         page::name_markup(r.pareto_figure) + "; the line between them guides the eye.</p>" + figure(plot) +
         front_list(r);
}

std::string price_section(const DesignReport& r) {
  page::Bars bars{r.by_bits ? "Bits with one requirement relaxed" : "Price with one requirement relaxed",
                  "The least that a design costs if the limit is looser by the part that is stated; the "
                  "first bar is the optimum.",
                  {},
                  {"", r.by_bits ? "bits" : r.price_unit, false, false}};
  const Design& d = *r.optimal;
  bars.bars.push_back({"as required", cost(r, d), cost_of(r, d.price, d.bits)});
  std::string none;
  for (const RequirementPrice& p : r.requirement_prices) {
    const std::string name = r.spec.requirements[p.requirement].name();
    if (const auto value = r.by_bits ? p.bits : p.price)
      bars.bars.push_back({name + ", " + percent(p.relaxed) + " looser", *value,
                           cost_of(r, p.price, p.bits.value_or(0)) + (p.proven ? "" : " or less")});
    else
      none += "<p>No price is known with " + page::name_markup(name) + " relaxed.</p>";
  }
  for (const std::size_t i : r.without_influence)
    none += "<p>No option changes " + page::name_markup(r.spec.requirements[i].name()) + ".</p>";
  if (bars.bars.size() == 1) return none + "<p>No requirement has been relaxed.</p>";
  return figure(bars) + none;
}

std::string hindrances(const DesignReport& r) {
  if (r.obstacles.empty()) return "<p>Nothing single: it is the requirements together.</p>";
  return page::list(r.obstacles);
}

page::Page infeasible_page(const DesignReport& r) {
  page::Page page{"Design of " + r.spec.robot_name,
                  r.proven ? "No design meets the requirements." : "No design was found.",
                  {{"What hinders", hindrances(r)}}};
  if (r.finest)
    page.sections.push_back({"The design that is nearest to all limits", chosen_section(r, *r.finest)});
  return page;
}

page::Page feasible_page(const DesignReport& r) {
  const Design& d = *r.optimal;
  std::string answer = "The optimum is the " + optimum_sentence(r);
  const std::string next = next_step(r);
  if (r.budget) answer += "; the budget is " + priced(*r.budget, r.price_unit);
  return {"Design of " + r.spec.robot_name,
          answer + '.' + (next.empty() ? "" : ' ' + next),
          {{"What to choose", chosen_section(r, d) +
                                  (r.runner_up ? page::paragraph("The " + runner_up_sentence(r) + '.') : "")},
           {"What each step of accuracy costs", front_section(r)},
           {"What each requirement costs", price_section(r)}}};
}

}  // namespace

page::Page page_of(const DesignReport& r) {
  page::Page page = r.optimal ? feasible_page(r) : infeasible_page(r);
  page.warnings = r.warnings;
  const auto& judged = r.optimal ? r.optimal : r.finest;
  describe(page, r.spec, judged ? std::optional(judged->results) : std::nullopt,
           r.optimal ? "The optimum" : "The design that is nearest to all limits");
  return page;
}

}  // namespace qerr
