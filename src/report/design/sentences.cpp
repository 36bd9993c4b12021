#include "report/design/sentences.hpp"

#include <cmath>

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

std::optional<double> design_margin(const Requirement& r, const RequirementResult& result) {
  if (!(r.limit > 0)) return std::nullopt;
  return r.at_least ? result.value / r.limit - 1 : 1 - result.value / r.limit;
}

}  // namespace qerr
