#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/text.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "report/diagnosis/parts.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

/// Names, at most four to keep the sentence readable.
std::string few_listed(std::vector<std::string> names) {
  constexpr std::size_t most = 4;
  if (names.size() > most) {
    const std::string more = std::to_string(names.size() - most + 1) + " more";
    names.resize(most - 1);
    names.push_back(more);
  }
  return listed(names);
}

std::string listed_causes(const Diagnosis& d) {
  std::vector<std::string> names;
  for (const Cause& c : d.causes) names.push_back(label(c));
  return few_listed(std::move(names));
}

/// "; not judged: elbow and tip"; "" if all is judged.
std::string unjudged_words(const Diagnosis& d) {
  std::vector<std::string> names;
  for (const std::string& place : d.unjudged) names.push_back(shown(place));
  return names.empty() ? "" : "; not judged: " + few_listed(std::move(names));
}

std::string cause_or_alternative(const Diagnosis& d) {
  if (d.causes.size() != 1 || d.alternatives.size() != 1)
    return listed_causes(d) + ", or other causes (below)";
  return d.causes.front().effect.type + " or " + d.alternatives.front().effect + " of " +
         shown(d.causes.front().effect.joint);
}

std::string unidentified_places(const Diagnosis& d) {
  std::vector<std::string> places;
  for (const Unidentified& u : d.unexplained) add_once(places, shown(u.joint));
  return listed(places);
}

/// Whether all that remains has one shape, at one joint.
bool has_one_shape(const Diagnosis& d) {
  return d.unexplained.size() == 1 && d.unexplained.front().shape != Shape::unknown;
}

std::string words_of_verdict(const DiagnosisReport& r) {
  const Diagnosis& d = r.diagnosis;
  switch (d.verdict) {
    case Verdict::nothing_wrong:
      return std::string(record_faults(d).empty() ? "" : "apart from them ") +
             "the log agrees with the model, its quantization and the noise of the reference";
    case Verdict::explained:
      return listed_causes(d);
    case Verdict::partly_explained:
      if (has_one_shape(d))
        return listed_causes(d) + "; there remains " + shape_words(r.spec, d.unexplained.front()) + " at " +
               unidentified_places(d);
      return listed_causes(d) + "; significant, unidentified errors at " + unidentified_places(d);
    case Verdict::ambiguous:
      return cause_or_alternative(d) + ": not distinguishable in this log";
    case Verdict::unexplained:
      if (has_one_shape(d))
        return unidentified_places(d) + " has " + shape_words(r.spec, d.unexplained.front()) +
               ", which no effect of the catalogue explains";
      return "significant errors at " + unidentified_places(d) + " that no effect of the catalogue explains";
    case Verdict::cannot_judge:
      return d.reason.empty() ? "the log has no reference sensor to compare the encoders with"
                              : escaped(d.reason);
  }
  return "";
}

bool is_coordinate(const Cause& c, const std::string& parameter) {
  const Parameter* const row = find_named(effect_kind(c.effect.type).parameters, parameter);
  return row && row->coordinate;
}

/// Degrees have no SI prefix.
std::string figure(double value, const std::string& unit) {
  return unit == "deg" ? significant(value, 3) + " deg" : readable(value, unit);
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
  const std::string size = size_words(r, c);
  return "  " + painted(label(c), Paint::bold, style) + (size.empty() ? "" : ": " + size) + '\n';
}

/// `2.77 counts (202 urad)`.
std::string rms_text(double rms, const std::string& unit, const Encoder* encoder) {
  const std::string text = readable(rms, unit);
  return encoder ? significant(rms / encoder->resolution, 3) + " counts (" + text + ')' : text;
}

/// The cause that an alternative replaces: that of its joint, else the first one of that effect; null: none.
const Cause* replaced(const Diagnosis& d, const AlternativeCause& a) {
  const Cause* first = nullptr;
  for (const Cause& c : d.causes) {
    if (c.effect.type != a.instead_of) continue;
    if (c.effect.joint == a.joint) return &c;
    if (!first) first = &c;
  }
  return first;
}

/// `latency`, `another eccentricity`, `geometry of a2`.
std::string alternative_name(const AlternativeCause& a, const Cause* cause) {
  if (!cause) return a.effect + " of " + shown(a.joint) + " instead of " + a.instead_of;
  if (a.joint != cause->effect.joint) return a.effect + " of " + shown(a.joint);
  return (a.effect == a.instead_of ? "another " : "") + a.effect;
}

std::string alternatives_of(const Diagnosis& d, const Cause* cause, const Style& style) {
  constexpr std::size_t most = 4;
  const std::vector<std::string> all = alternatives_to(d, cause);
  const std::size_t rows = style.details ? all.size() : std::min(most, all.size());
  std::string out;
  for (std::size_t i = 0; i < rows; ++i) out += (cause ? "    or: " : "  ") + all[i] + '\n';
  return out + (rows < all.size()
                    ? "    and " + std::to_string(all.size() - rows) + " more alternatives: --details\n"
                    : "");
}

std::string cell(const Diagnosis& d, const std::string& effect, const std::string& joint) {
  for (const Visible& v : d.visible)
    if (v.effect == effect && v.joint == joint && std::isfinite(v.smallest))
      return v.unit.empty()
                 ? significant(v.smallest, 2)
                 : significant(rounded_to(v.smallest, 2) / prefixed(v.smallest, v.unit).factor, 2) + ' ' +
                       prefixed(v.smallest, v.unit).unit;
  return "-";
}

/// As many decimals as give the interval two digits.
std::string fitted(double value, double half, double scale, const std::string& unit) {
  const int decimals = std::clamp(1 - static_cast<int>(std::floor(std::log10(half / scale))), 0, 6);
  return fixed_point(value / scale, decimals) + " +- " + fixed_point(half / scale, decimals) + ' ' + unit;
}

}  // namespace

std::string label(const Cause& c) {
  const double order = c.effect.number_or("order", 0);
  return c.effect.type + (order > 0 && order != 1 ? " (order " + significant(order, 4) + ")" : "") + " of " +
         shown(c.effect.joint);
}

std::string verdict_title(const Diagnosis& d) {
  std::string word(name(d.verdict));
  if (d.verdict == Verdict::nothing_wrong && !is_faultless(d)) {
    std::vector<std::string> faults;
    for (const DataKind kind : record_faults(d)) faults.emplace_back(name(kind));
    const std::string readings = faults.empty() ? "" : listed(faults) + " readings";
    const std::string part = d.unjudged.empty() ? "" : "not all judged";
    word += ", but " + readings + (faults.empty() || part.empty() ? "" : ", and ") + part;
  }
  std::ranges::replace(word, '_', ' ');
  std::ranges::transform(word, word.begin(),
                         [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; });
  return word;
}

std::string verdict_words(const DiagnosisReport& r) {
  const bool judged = r.diagnosis.verdict != Verdict::cannot_judge;
  return words_of_verdict(r) + (judged ? unjudged_words(r.diagnosis) : "");
}

std::string place_of(const Cause& c) { return c.gain.of_tip ? "the tip" : shown(c.effect.joint); }

std::string size_words(const DiagnosisReport& r, const Cause& c) {
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
  return joined(parts);
}

std::string loss_words(const DiagnosisReport& r, const Cause& c) {
  const Encoder* encoder = c.gain.of_tip ? nullptr : encoder_of(r.spec, c.effect.joint);
  const bool alone = std::isfinite(c.rms_without);
  const double without = alone ? c.rms_without : c.gain.rms_before;
  if (!(without > 0)) return "";
  return "residual at " + place_of(c) + ": " + rms_text(without, c.gain.unit, encoder) + " rms without " +
         (alone ? "it" : "any cause") + ", " + rms_text(c.gain.rms_after, c.gain.unit, encoder) + " with " +
         (alone ? "it" : "all");
}

std::vector<std::string> alternatives_to(const Diagnosis& d, const Cause* cause) {
  ItemGroups groups;  // names by advice
  for (const AlternativeCause& a : d.alternatives) {
    if (replaced(d, a) != cause) continue;
    add_to_group(groups, a.record, alternative_name(a, cause));
  }
  std::vector<std::string> lines;
  for (const auto& [record, names] : groups)
    lines.push_back(listed(names) +
                    (record.empty() ? "" : "; to tell them apart, record " + escaped(record)));
  return lines;
}

std::string causes_section(const DiagnosisReport& r, const Style& style) {
  const Diagnosis& d = r.diagnosis;
  std::string out;
  for (const Cause& c : d.causes) {
    const std::string loss = loss_words(r, c);
    out += size_line(r, c, style) + (loss.empty() ? "" : "    " + loss + '\n') +
           "    remedy: " + std::string(effect_kind(c.effect.type).remedy.text) + '\n' +
           alternatives_of(d, &c, style) + curve_picture(r.spec, c.effect.joint, c.curve, style);
  }
  out += alternatives_of(d, nullptr, style);
  return out.empty() ? "" : heading("Causes", style) + out;
}

TableRows visible_sizes(const Diagnosis& d) {
  std::vector<std::string> effects, joints;
  for (const Visible& v : d.visible)
    if (std::isfinite(v.smallest)) add_once(effects, v.effect), add_once(joints, v.joint);
  if (effects.empty()) return {};
  TableRows rows{{"effect"}};
  for (const std::string& joint : joints) rows.front().push_back(shown(joint));
  for (const std::string& effect : effects) {
    rows.push_back({effect});
    for (const std::string& joint : joints) rows.back().push_back(cell(d, effect, joint));
  }
  return rows;
}

std::vector<std::string> hidden_lines(const Diagnosis& d) {
  std::vector<std::pair<std::string, std::string>> groups;  // joint, reason
  for (const Visible& v : d.visible) {
    const std::pair<std::string, std::string> group{v.joint, v.hidden_by};
    if (!std::isfinite(v.smallest) && !contains(groups, group)) groups.push_back(group);
  }
  std::vector<std::string> out;
  for (const auto& [joint, reason] : groups) {
    std::vector<std::string> effects;
    for (const Visible& v : d.visible)
      if (!std::isfinite(v.smallest) && v.joint == joint && v.hidden_by == reason)
        add_once(effects, v.effect);
    out.push_back(shown(joint) + (reason.empty() ? "" : ", " + escaped(reason)) + ": " + listed(effects));
  }
  return out;
}

std::string visible_section(const DiagnosisReport& r, const Style& style) {
  const Diagnosis& d = r.diagnosis;
  if (d.verdict != Verdict::nothing_wrong && !style.details) return "";
  const TableRows sizes = visible_sizes(d);
  const std::vector<std::string> hidden = hidden_lines(d);
  std::string out;
  if (!sizes.empty())
    out = heading("What this record would have shown, from these sizes on", style) +
          fitted_table(sizes, style.width);
  if (hidden.empty()) return out;
  out += heading("What this motion hides", style);
  for (const std::string& line : hidden) out += "  " + line + '\n';
  return out + "  `qerr diagnose SPEC --plan` proposes a motion that shows more.\n";
}

std::string with_interval(const ReportedParameter& parameter) {
  ReportedParameter p = parameter;
  if (p.figure.name == "phase" && p.unit == "rad") {
    for (double* angle : {&p.figure.value, &p.figure.lower, &p.figure.upper})
      *angle *= 180 / std::numbers::pi;
    p.unit = "deg";
  }
  const auto& [name, value, lower, upper] = p.figure;
  if (p.fixed)
    return p.unit.empty() || p.unit == "deg" ? significant(value, 6) + (p.unit.empty() ? "" : " deg")
                                             : readable(value, p.unit);
  const double half = 0.5 * (upper - lower);
  if (p.unit.empty())
    return significant(value, 4) + " (" + significant(lower, 4) + " .. " + significant(upper, 4) + ')';
  if (!(std::abs(0.5 * (upper + lower) - value) < 0.2 * half) || std::abs(value) < half)
    return figure(value, p.unit) + " (" + figure(lower, p.unit) + " .. " + figure(upper, p.unit) + ')';
  if (p.unit == "deg") return fitted(value, half, 1, "deg");
  // One prefix for both, and as many decimals as give the interval two digits.
  const int thousand =
      std::clamp(static_cast<int>(std::floor(std::log10(std::max(std::abs(value), half)) / 3)), -4, 3);
  static constexpr const char* prefixes[] = {"p", "n", "u", "m", "", "k", "M", "G"};
  return fitted(value, half, std::pow(1000.0, thousand), prefixes[thousand + 4] + p.unit);
}

}  // namespace qerr
