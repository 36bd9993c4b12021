#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "report/diagnosis/parts.hpp"
#include "report/diagnosis/sentences.hpp"
#include "report/fitted_table.hpp"
#include "report/formats.hpp"
#include "report/text_table.hpp"
#include "report/wrapped_text.hpp"

namespace qerr {

namespace {

std::string probability(double p) { return p < 1e-15 ? "p < 1e-15" : "p = " + significant(p, 2); }

std::string counts(double value) { return significant(value, 3) + " counts"; }

std::string verdict_line(const Diagnosis& d, const Style& style) {
  std::string word(name(d.verdict));
  std::replace(word.begin(), word.end(), '_', ' ');
  std::transform(word.begin(), word.end(), word.begin(),
                 [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; });
  const Paint color = d.verdict == Verdict::nothing_wrong ? Paint::green : Paint::yellow;
  return painted(word, color, style) + ": " + verdict_words(d) + "\n";
}

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

/// The figure with its interval, and a coordinate also in counts.
std::string parameter_line(const Spec& spec, const Cause& cause, const ReportedParameter& p) {
  std::string text = with_interval(p);
  const Encoder* encoder = encoder_of(spec, cause.effect.joint);
  if (!encoder) return text;
  for (const Parameter& row : effect_kind(cause.effect.type).parameters)
    if (row.name == p.figure.name && row.coordinate)
      text += " = " + counts(p.figure.value / encoder->resolution);
  return text;
}

std::string share_of(double share) {
  return share < 0.01 ? "under 1 %" : std::to_string(std::lround(100 * std::min(share, 1.0))) + " %";
}

std::string causes_table(const DiagnosisReport& r, const Style& style) {
  std::string out;
  for (const Cause& c : r.diagnosis.causes) {
    const double share = c.gain.rms_before > 0 ? std::pow(c.rms / c.gain.rms_before, 2) : 0;
    out += "  " + painted(label(c), Paint::bold, style) + "  " + probability(c.p_value);
    if (share > 0) out += ", " + share_of(share) + " of the joint's residual variance";
    out += '\n';
    std::vector<std::vector<std::string>> rows;
    for (const ReportedParameter& p : reported_parameters(r.spec, c))
      rows.push_back({p.figure.name + "  " + parameter_line(r.spec, c, p)});
    for (const auto& [choice, word] : c.effect.choices) rows.push_back({choice + "  " + word});
    out += aligned(rows, "    ");
    out += "    remedy: " + std::string(effect_kind(c.effect.type).remedy.text) + '\n';
  }
  return out;
}

/// One line for all alternatives of the same effect and joint.
std::string alternatives_list(const Diagnosis& d) {
  std::vector<std::string> lines;
  for (const AlternativeCause& a : d.alternatives) {
    const std::string line = "  " + std::string(a.effect == a.instead_of ? "another " : "") + a.effect +
                             " instead of " + a.instead_of + " of " + shown(a.joint) +
                             (a.record.empty() ? "" : "; to distinguish them, record " + escaped(a.record)) +
                             '\n';
    if (std::find(lines.begin(), lines.end(), line) == lines.end()) lines.push_back(line);
  }
  std::string out;
  for (const std::string& line : lines) out += line;
  return out;
}

std::string unexplained_list(const DiagnosisReport& r) {
  std::string out;
  for (const Unidentified& u : r.diagnosis.unexplained) {
    const std::string unit = coordinate_unit(r.spec, u.joint);
    out += "  " + shown(u.joint) + ": " + escaped(u.what);
    if (u.order && *u.order > 0)
      out += ", order " + significant(*u.order, 4) +
             (unit == "m" ? " per metre" : " per revolution of the joint");
    if (u.frequency) out += ", " + readable(*u.frequency, "Hz");
    if (u.amplitude > 0) out += ", amplitude " + readable(u.amplitude, unit);
    if (const Encoder* encoder = encoder_of(r.spec, u.joint); encoder && u.amplitude > 0)
      out += " = " + counts(u.amplitude / encoder->resolution);
    out += '\n';
  }
  return out;
}

/// The joint, or the tip, whose residual the cause's gain refers to.
std::string place_of(const Cause& c) { return c.gain.of_tip ? "tip" : shown(c.effect.joint); }

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

std::string gain_table(const Diagnosis& d, const Style& style) {
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
    rows.push_back(gain_row("all joints", d.gain));
  return fitted_table(rows, style.width) +
         (d.gain.held_out ? "  after: on held-out blocks of the log\n" : "");
}

/// The error that remains at each place after a compensation, and the quantization that no compensation
/// removes.
std::string compensation(const DiagnosisReport& r) {
  std::string out;
  std::vector<std::string> seen;
  for (const Cause& c : r.diagnosis.causes) {
    const Encoder* encoder = encoder_of(r.spec, c.effect.joint);
    if (!encoder || !effect_kind(c.effect.type).remedy.in_controller) continue;
    const std::string place = (c.gain.of_tip ? "the " : "") + place_of(c);
    if (std::find(seen.begin(), seen.end(), place) != seen.end()) continue;
    seen.push_back(place);
    constexpr double worthwhile = 1.05;
    if (c.gain.ratio() < worthwhile) {
      out += "  A compensation in the controller would not reduce the error at " + place + ".\n";
      continue;
    }
    out += "  A compensation in the controller would reduce the rms error at " + place + " from " +
           readable(c.gain.rms_before, c.gain.unit) + " to " + readable(c.gain.rms_after, c.gain.unit);
    // At the tip the quantization of all encoders adds up: see `qerr analyze`.
    if (!c.gain.of_tip) out += "; quantization alone causes " + readable(sigma(*encoder), c.gain.unit);
    out += ".\n";
  }
  return out;
}

std::string record_line(const Log& log) {
  std::string out = "'" + escaped(log.file) + "': " + counted(log.rows, "row");
  if (log.has_time()) out += " over " + significant(log.last_time - log.first_time, 4) + " s";
  for (const LogColumn& c : log.columns)
    if (c.wraps.count > 0 || c.wraps.start != 0)
      out += "\n  unwrapped: " + escaped(c.header) + ", " + counted(c.wraps.count, "full turn") +
             (c.wraps.start ? ", " + std::to_string(c.wraps.start) + " at the start" : "");
  return out + '\n';
}

}  // namespace

std::string to_table(const DiagnosisReport& r, const Style& style) {
  const Diagnosis& d = r.diagnosis;
  std::string out = painted("qerr diagnose", Paint::bold, style) + "  robot '" +
                    escaped(r.spec.robot_name, 60) + "', " + record_line(r.log) + '\n' +
                    verdict_line(d, style);
  out += simulation_table(d, style);
  if (!d.causes.empty()) out += heading("Causes, with 95 % intervals", style) + causes_table(r, style);
  if (!d.alternatives.empty()) out += heading("Possible alternatives", style) + alternatives_list(d);
  if (!d.unexplained.empty()) out += heading("Significant, unidentified", style) + unexplained_list(r);
  if (d.verdict == Verdict::cannot_judge) return within(out, style.width);
  out += heading(d.causes.empty() ? "Residual" : "Improvement with the extended model", style) +
         gain_table(d, style) + compensation(r);
  if (!r.extended_model.empty()) out += "\nExtended model: " + escaped(r.extended_model) + '\n';
  return within(out, style.width);
}

}  // namespace qerr
