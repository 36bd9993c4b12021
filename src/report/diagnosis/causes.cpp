#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/text.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "report/diagnosis/parts.hpp"
#include "report/diagnosis/sections.hpp"
#include "report/diagnosis/sentences.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

bool is_coordinate(const Cause& c, const std::string& parameter) {
  const auto& rows = effect_kind(c.effect.type).parameters;
  return std::any_of(rows.begin(), rows.end(),
                     [&](const Parameter& p) { return p.name == parameter && p.coordinate; });
}

/// A coordinate also in arc units and in counts; a phase without its interval, which --details has.
std::string parameter_text(const DiagnosisReport& r, const Cause& c, const ReportedParameter& p) {
  const Encoder* encoder = encoder_of(r.spec, c.effect.joint);
  if (p.figure.name == "phase" && p.unit == "rad")
    return "phase " + significant(p.figure.value * 180 / std::numbers::pi, 3) + " deg";
  std::string text = p.figure.name + ' ' + with_interval(p);
  if (!is_coordinate(c, p.figure.name)) return text;
  if (p.unit == "rad") text += " = " + arc_text(p.figure.value);
  if (encoder) text += " = " + significant(p.figure.value / encoder->resolution, 3) + " counts";
  return text;
}

/// `backlash of j2: gap 400.03 +- 0.11 urad = 1.38 arcmin = 5.49 counts`.
std::string size_line(const DiagnosisReport& r, const Cause& c, const Style& style) {
  std::vector<std::string> parts;
  bool in_counts = false;
  for (const ReportedParameter& p : reported_parameters(r.spec, c)) {
    if (p.figure.name == "order") continue;  // in the label
    in_counts = in_counts || is_coordinate(c, p.figure.name);
    parts.push_back(parameter_text(r, c, p));
  }
  for (const auto& [choice, word] : c.effect.choices) parts.push_back(choice + ' ' + word);
  const Encoder* encoder = encoder_of(r.spec, c.effect.joint);
  if (!in_counts && encoder && c.rms > 0)
    parts.push_back(significant(c.rms / encoder->resolution, 3) + " counts rms in this record");
  std::string out = "  " + painted(label(c), Paint::bold, style);
  for (std::size_t i = 0; i < parts.size(); ++i) out += (i ? ", " : ": ") + parts[i];
  return out + '\n';
}

/// `2.77 counts (202 urad)`.
std::string rms_text(double rms, const std::string& unit, const Encoder* encoder) {
  const std::string text = readable(rms, unit);
  return encoder ? significant(rms / encoder->resolution, 3) + " counts (" + text + ')' : text;
}

/// What is lost without the cause; where that is unknown, what all causes of its place remove together.
std::string loss_line(const DiagnosisReport& r, const Cause& c) {
  const Encoder* encoder = c.gain.of_tip ? nullptr : encoder_of(r.spec, c.effect.joint);
  const bool alone = std::isfinite(c.rms_without);
  const double without = alone ? c.rms_without : c.gain.rms_before;
  if (!(without > 0)) return "";
  return "    residual at " + place_of(c) + ": " + rms_text(without, c.gain.unit, encoder) + " rms without " +
         (alone ? "it" : "any cause") + ", " + rms_text(c.gain.rms_after, c.gain.unit, encoder) + " with " +
         (alone ? "it" : "all") + '\n';
}

std::string record_text(const std::string& record) {
  return record.empty() ? "" : "; to tell them apart, record " + escaped(record);
}

bool is_instead_of(const AlternativeCause& a, const Cause& c) {
  return a.instead_of == c.effect.type && a.joint == c.effect.joint;
}

std::string joined_lines(const std::vector<std::string>& lines) {
  std::string out;
  for (const std::string& line : lines) out += line;
  return out;
}

/// One line per alternative. Those of a cause that stands twice are shown at its first place alone.
std::string alternatives_of(const Diagnosis& d, const Cause& c) {
  const auto first = std::find_if(d.causes.begin(), d.causes.end(), [&](const Cause& other) {
    return other.effect.type == c.effect.type && other.effect.joint == c.effect.joint;
  });
  if (&*first != &c) return "";
  std::vector<std::string> lines;
  for (const AlternativeCause& a : d.alternatives)
    if (is_instead_of(a, c))
      add_once(lines, std::string("    or: ") + (a.effect == a.instead_of ? "another " : "") + a.effect +
                          record_text(a.record) + '\n');
  return joined_lines(lines);
}

/// Alternatives to what is not a cause of the list.
std::string other_alternatives(const Diagnosis& d) {
  std::vector<std::string> lines;
  for (const AlternativeCause& a : d.alternatives)
    if (std::none_of(d.causes.begin(), d.causes.end(), [&](const Cause& c) { return is_instead_of(a, c); }))
      add_once(lines, "  " + a.effect + " instead of " + a.instead_of + " of " + shown(a.joint) +
                          record_text(a.record) + '\n');
  return joined_lines(lines);
}

}  // namespace

std::string place_of(const Cause& c) { return c.gain.of_tip ? "the tip" : shown(c.effect.joint); }

std::string causes_section(const DiagnosisReport& r, const Style& style) {
  const Diagnosis& d = r.diagnosis;
  std::string out;
  for (const Cause& c : d.causes)
    out += size_line(r, c, style) + loss_line(r, c) +
           "    remedy: " + std::string(effect_kind(c.effect.type).remedy.text) + '\n' +
           alternatives_of(d, c) + curve_picture(r.spec, c.effect.joint, c.curve, style);
  out += other_alternatives(d);
  return out.empty() ? "" : heading("Causes", style) + out;
}

}  // namespace qerr
