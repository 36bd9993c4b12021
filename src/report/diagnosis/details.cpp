#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "report/diagnosis/parts.hpp"
#include "report/diagnosis/sections.hpp"
#include "report/diagnosis/sentences.hpp"
#include "report/fitted_table.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

std::string probability(double p) { return p < 1e-15 ? "p < 1e-15" : "p = " + significant(p, 2); }

/// The statistics that the model does not explain, most significant first; the JSON has all.
std::string simulation_table(const Diagnosis& d, const Style& style) {
  constexpr std::size_t most = 8;
  constexpr double significance_level = 0.01;
  std::vector<Comparison> list;
  std::copy_if(d.simulation.begin(), d.simulation.end(), std::back_inserter(list),
               [](const Comparison& c) { return c.p_value < significance_level; });
  std::stable_sort(list.begin(), list.end(),
                   [](const Comparison& a, const Comparison& b) { return a.p_value < b.p_value; });
  std::vector<std::vector<std::string>> rows{{"joint", "statistic", "observed", "expected", "p"}};
  for (std::size_t i = 0; i < std::min(list.size(), most); ++i)
    rows.push_back({shown(list[i].joint), list[i].statistic, significant(list[i].observed, 3),
                    significant(list[i].expected, 3),
                    list[i].p_value < 1e-15 ? "< 1e-15" : significant(list[i].p_value, 2)});
  if (list.empty()) return "";
  return heading("Statistics that the simulated model does not reproduce", style) + aligned(rows) +
         (list.size() > most ? "  and " + std::to_string(list.size() - most) + " more (--format json)\n"
                             : "");
}

std::vector<std::string> gain_row(const std::string& label, const Gain& g) {
  const auto in_counts = [](double value) { return std::isfinite(value) ? significant(value, 3) : "-"; };
  return {label,
          readable(g.rms_before, g.unit),
          readable(g.rms_after, g.unit),
          in_counts(g.counts_before),
          in_counts(g.counts_after),
          significant(g.ratio(), 3),
          g.upper > 0 ? significant(g.lower, 3) + " .. " + significant(g.upper, 3) : ""};
}

}  // namespace

std::string parameter_size(const Spec& spec, const Cause& cause, const ReportedParameter& p) {
  std::string text = with_interval(p);
  const Encoder* encoder = encoder_of(spec, cause.effect.joint);
  if (!encoder) return text;
  for (const Parameter& row : effect_kind(cause.effect.type).parameters)
    if (row.name == p.figure.name && row.coordinate)
      text += " = " + significant(p.figure.value / encoder->resolution, 3) + " counts";
  return text;
}

std::vector<std::vector<std::string>> gain_rows(const Diagnosis& d) {
  std::vector<std::vector<std::string>> rows{
      {"residual, rms", "before", "after", "counts before", "after", "ratio", "95 %"}};
  std::vector<std::string> seen;
  for (const Cause& c : d.causes) {
    if (std::find(seen.begin(), seen.end(), place_of(c)) != seen.end()) continue;
    seen.push_back(place_of(c));
    rows.push_back(gain_row(seen.back(), c.gain));
  }
  // The total of a single place would repeat its row.
  if (seen.size() != 1 || d.causes.front().gain.rms_before != d.gain.rms_before)
    rows.push_back(gain_row(d.gain.of_tip ? "the tip" : "all joints", d.gain));
  return rows;
}

std::vector<std::string> prediction_lines(const Gain& g) {
  std::vector<std::string> out;
  if (std::isfinite(g.coverage))
    out.push_back(percent(g.coverage) + " of the readings are in the extended model's central 95 % interval");
  if (std::isfinite(g.log_score))
    out.push_back("log-likelihood per reading: " + significant(g.log_score, 3) +
                  " more than without the causes");
  return out;
}

namespace {

std::string share_of(double share) {
  return share < 0.01 ? "under 1 %" : std::to_string(std::lround(100 * std::min(share, 1.0))) + " %";
}

std::string causes_table(const DiagnosisReport& r) {
  std::string out;
  for (const Cause& c : r.diagnosis.causes) {
    const double share = c.gain.rms_before > 0 ? std::pow(c.rms / c.gain.rms_before, 2) : 0;
    out += "  " + label(c) + "  " + probability(c.p_value);
    if (share > 0) out += ", " + share_of(share) + " of the joint's residual variance";
    out += '\n';
    std::vector<std::vector<std::string>> rows;
    for (const ReportedParameter& p : reported_parameters(r.spec, c))
      rows.push_back({p.figure.name + "  " + parameter_size(r.spec, c, p)});
    out += aligned(rows, "    ");
  }
  return out;
}

std::string gain_table(const Diagnosis& d, const Style& style) {
  std::string out = fitted_table(gain_rows(d), style.width) +
                    (d.gain.held_out ? "  after: on held-out blocks of the log\n" : "");
  for (const std::string& line : prediction_lines(d.gain)) out += "  " + line + '\n';
  return out;
}

}  // namespace

std::string details_section(const DiagnosisReport& r, const Style& style) {
  const Diagnosis& d = r.diagnosis;
  std::string out = simulation_table(d, style);
  if (!d.causes.empty()) out += heading("Parameters, with 95 % intervals", style) + causes_table(r);
  if (d.verdict == Verdict::cannot_judge) return out;
  return out + heading(d.causes.empty() ? "Residual" : "Improvement with the extended model", style) +
         gain_table(d, style);
}

}  // namespace qerr
