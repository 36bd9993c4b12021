#include "report/formats.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "report/analysis/figures.hpp"
#include "report/analysis/tables.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

/// `120 EUR`, with cents if there are any; `-` if it is not stated.
std::string priced(std::optional<double> stated, const std::string& unit) {
  if (!stated) return "-";
  const double price = *stated, cents = std::round(100 * price);
  const bool whole = std::fmod(cents, 100) == 0;
  return (whole ? fixed_point(price, 0) : fixed_point(price, 2)) + (unit.empty() ? "" : ' ' + shown(unit));
}

std::string bits_text(double bits) { return fixed_point(bits, 2) + " bits"; }

/// What the design costs: its price, or the sum of its bits.
std::string cost_of(const DesignReport& r, std::optional<double> price, double bits) {
  return r.by_bits ? bits_text(bits) : priced(price, r.price_unit);
}

/// Family, order, cut-off, noise, delay and tracking error.
std::string filter_sentence(const DesignedFilter& f) {
  const std::string unit = f.filter.filter.derivative == 0 ? "" : "1/s";
  std::string text = shown(f.name) + ": " + f.family + ", order " + std::to_string(f.order) + ", " +
                     readable(f.cutoff, "Hz") + "; noise " + significant(f.filter.norms.h2, 4) +
                     (unit.empty() ? "" : ' ' + unit) + ", delay " + readable(f.delay, "s");
  if (f.tracking) text += ", tracking error " + percent(*f.tracking) + " up to " + readable(f.band, "Hz");
  return text;
}

/// `kp 400 N m/rad of a1 and a2`; empty without gains.
std::vector<std::string> gain_sentences(const DesignReport& report, const Design& d) {
  ItemGroups joints_by_gain;
  for (const DesignedGain& g : d.gains) {
    const bool prismatic = find_named(report.spec.model.chain.independent, g.joint)->prismatic();
    const std::string text = g.key + ' ' + significant(g.value, 4) + (prismatic ? " N" : " N m") +
                             (g.key == "kd" ? " s" : "") + (prismatic ? "/m" : "/rad");
    add_to_group(joints_by_gain, text, shown(g.joint));
  }
  std::vector<std::string> all;
  for (const auto& [text, joints] : joints_by_gain) all.push_back(text + " of " + listed(joints));
  return all;
}

/// How far the filter is from the quietest one of its tracking error; "" where that is not known.
std::string best_linear_sentence(const DesignedFilter& f) {
  if (!f.best_linear) return "";
  const auto& b = *f.best_linear;
  const double memory = static_cast<double>(b.taps) / f.filter.filter.sample_rate;
  return "the quietest linear filter of that tracking error with a memory of " + readable(memory, "s") +
         " (" + std::to_string(b.taps) + " taps): " + significant(b.h2, 4) + "; the chosen one has " +
         significant(f.filter.norms.h2 / b.h2, 3) + " times its noise";
}

/// @pre there is an optimum
std::string optimum_sentence(const DesignReport& report) {
  const Design& d = *report.optimal;
  std::string text = report.goal == "price" ? "cheapest: " + priced(d.price, report.price_unit)
                     : report.goal == "resolution"
                         ? "coarsest: " + bits_text(d.bits)
                         : "least " + report.goal + ": " + readable(*d.minimized, report.goal_unit) +
                               (d.encoders.empty() ? "" : " for " + cost_of(report, d.price, d.bits));
  if (report.proven) return text + (d.encoders.empty() ? "" : ", proven");
  text += ", NOT proven";
  if (report.bound)
    text += ": the optimum is at least " +
            (report.by_bits ? bits_text(*report.bound) : priced(*report.bound, report.price_unit));
  return text;
}

/// The bits or the price of a design, of a point of the front or of an encoder.
template <class Priced>
double cost(const DesignReport& r, const Priced& of) {
  return r.by_bits ? of.bits : of.price.value_or(0);
}

/// What the runner-up changes. @pre there is one
std::string runner_up_sentence(const DesignReport& report) {
  const Design &a = *report.optimal, &b = *report.runner_up;
  std::vector<std::string> changes;
  for (std::size_t i = 0; i < a.encoders.size(); ++i)
    if (a.encoders[i].name != b.encoders[i].name)
      changes.push_back(shown(b.encoders[i].joint) + ' ' + shown(b.encoders[i].name));
  if (changes.empty())
    for (const DesignedFilter& f : b.filters) changes.push_back(filter_sentence(f));
  const std::string price = b.encoders.empty() ? "" : " for " + cost_of(report, b.price, b.bits);
  const std::string cost = b.minimized          ? readable(*b.minimized, report.goal_unit) + price
                           : b.encoders.empty() ? "no dearer"
                                                : cost_of(report, b.price, b.bits);
  return "runner-up: " + cost + ", with " + listed(changes);
}

std::string row(const std::string& design, const std::string& what, const std::string& name,
                const std::string& value, const std::string& unit) {
  return design + ',' + what + ',' + csv_cell(name) + ',' + csv_cell(value) + ',' + csv_cell(unit) + "\r\n";
}

std::string requirement_table(const DesignReport& report, const Design& d, const Style& style) {
  TableRows rows{{"requirement", "value", "", "limit", "margin", "if 10 % looser"}};
  for (std::size_t i = 0; i < d.results.size(); ++i) {
    const Requirement& r = report.spec.requirements[i];
    std::string looser;
    for (const RequirementPrice& p : report.requirement_prices)
      if (p.requirement == i && p.bits)
        looser = cost_of(report, p.price, p.bits.value_or(0)) + (p.proven ? "" : " or less");
    rows.push_back({shortened(r.quantity, 32) + (r.statistic.empty() ? "" : ' ' + r.statistic),
                    value_text(r, d.results[i].value), relation(r.at_least, d.results[i].met),
                    readable(r.limit, r.unit), d.results[i].met ? margin_text(r, d.results[i]) : "NOT MET",
                    looser});
  }
  if (report.requirement_prices.empty())
    for (auto& row : rows) row.pop_back();
  return rows.size() > 1 ? fitted_table(rows, style.width) : "";
}

std::string choices(const DesignReport& report, const Design& d, const Style& style) {
  std::string out;
  if (!d.encoders.empty()) {
    TableRows rows{{"joint", "encoder", "price", "bits at the joint"}};
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
  for (const std::string& text : gain_sentences(report, d)) out += wrapped(text, style.width, "  ");
  return out;
}

std::string front_table(const DesignReport& report, const Style& style) {
  if (report.pareto.size() < 2) return "";
  const bool by_bits = report.by_bits;
  TableRows rows{{by_bits ? "bits" : "price", report.pareto_figure}};
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
  if (r.finest) page.add("The design that is nearest to all limits", chosen_section(r, *r.finest));
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

using ReportedDesign = In<Design, DesignReport>;
using ReportedRequirement = In<RequirementResult, ReportedDesign>;
using Best = DesignedFilter::BestLinear;

std::map<std::string, std::map<std::string, double>> gains_by_joint(const Design& d) {
  std::map<std::string, std::map<std::string, double>> all;
  for (const DesignedGain& g : d.gains) all[g.joint][g.key] = g.value;
  return all;
}

auto option_names(const std::vector<DesignedEncoder>& encoders) {
  return by_name(encoders, &DesignedEncoder::joint, &DesignedEncoder::name);
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

page::Page page_of(const DesignReport& r) {
  page::Page page = r.optimal ? feasible_page(r) : infeasible_page(r);
  page.warnings = r.warnings;
  const auto& judged = r.optimal ? r.optimal : r.finest;
  describe(page, r.spec, judged ? std::optional(judged->results) : std::nullopt,
           r.optimal ? "The optimum" : "The design that is nearest to all limits");
  return page;
}

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
