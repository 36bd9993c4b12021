#include "report/design/table.hpp"

#include <algorithm>
#include <cmath>

#include "report/analysis/requirements.hpp"
#include "report/formats.hpp"
#include "report/text_table.hpp"

namespace qerr {

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

std::string filter_sentence(const DesignedFilter& f) {
  const std::string unit = f.filter.filter.derivative == 0 ? "" : "1/s";
  std::string text = shown(f.name) + ": " + f.family + ", order " + std::to_string(f.order) + ", " +
                     readable(f.cutoff, "Hz") + "; noise " + significant(f.filter.norms.h2, 4) +
                     (unit.empty() ? "" : ' ' + unit) + ", delay " + readable(f.delay, "s");
  if (f.tracking) text += ", tracking error " + percent(*f.tracking) + " up to " + readable(f.band, "Hz");
  return text;
}

std::vector<std::string> gain_sentences(const DesignReport& report, const Design& d) {
  std::vector<std::pair<std::string, std::vector<std::string>>> joints_by_gain;
  for (const DesignedGain& g : d.gains) {
    const auto& joints = report.spec.model.chain.independent;
    const bool prismatic = std::any_of(joints.begin(), joints.end(), [&](const IndependentJoint& j) {
      return j.name == g.joint && j.prismatic();
    });
    const std::string text = g.key + ' ' + significant(g.value, 4) + (prismatic ? " N" : " N m") +
                             (g.key == "kd" ? " s" : "") + (prismatic ? "/m" : "/rad");
    const auto known = std::find_if(joints_by_gain.begin(), joints_by_gain.end(),
                                    [&](const auto& entry) { return entry.first == text; });
    if (known == joints_by_gain.end())
      joints_by_gain.push_back({text, {shown(g.joint)}});
    else
      known->second.push_back(shown(g.joint));
  }
  std::vector<std::string> all;
  for (const auto& [text, joints] : joints_by_gain) all.push_back(text + " of " + listed(joints));
  return all;
}

std::string best_linear_sentence(const DesignedFilter& f) {
  if (!f.best_linear) return "";
  const auto& b = *f.best_linear;
  const double memory = static_cast<double>(b.taps) / f.filter.filter.sample_rate;
  return "the quietest linear filter of that tracking error with a memory of " + readable(memory, "s") +
         " (" + std::to_string(b.taps) + " taps): " + significant(b.h2, 4) + "; the chosen one has " +
         significant(f.filter.norms.h2 / b.h2, 3) + " times its noise";
}

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

namespace {

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
