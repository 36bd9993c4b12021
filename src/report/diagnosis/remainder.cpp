#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "report/diagnosis/parts.hpp"
#include "report/diagnosis/sections.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

/// `0.294 counts (34.4 urad) rms; quantization and the stated noise leave 0.288 counts`.
std::string remainder_line(const std::string& place, const Gain& g) {
  const bool in_counts = std::isfinite(g.counts_after);
  std::string out = place + ": ";
  out += in_counts ? significant(g.counts_after, 3) + " counts (" + readable(g.rms_after, g.unit) + ") rms"
                   : readable(g.rms_after, g.unit) + " rms";
  if (std::isfinite(g.sigma_ratio) && g.sigma_ratio > 0)
    out += "; quantization and the stated noise leave " +
           (in_counts ? significant(g.counts_after / g.sigma_ratio, 3) + " counts"
                      : readable(g.rms_after / g.sigma_ratio, g.unit));
  return out;
}

}  // namespace

std::vector<std::string> remainder_lines(const Diagnosis& d) {
  if (d.verdict == Verdict::cannot_judge) return {};
  std::vector<std::string> seen, out;
  for (const Cause& c : d.causes) {
    if (std::find(seen.begin(), seen.end(), place_of(c)) != seen.end()) continue;
    seen.push_back(place_of(c));
    out.push_back(remainder_line(seen.back(), c.gain));
  }
  if (seen.empty() && d.gain.rms_after > 0)
    out.push_back(remainder_line(d.gain.of_tip ? "the tip" : "all joints", d.gain));
  return out;
}

std::string place_of(const DataFinding& f) {
  std::vector<std::string> parts;
  if (!f.joint.empty()) parts.push_back(shown(f.joint));
  if (f.row) parts.push_back("row " + std::to_string(*f.row));
  if (f.time) parts.push_back(significant(*f.time, 6) + " s");
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : ", ") + part;
  return text.empty() ? "the whole record" : text;
}

std::vector<std::string> advice_lines(const Diagnosis& d) {
  std::vector<std::string> out;
  std::vector<std::string> seen;
  for (const Unidentified& u : d.unexplained) {
    // What is wrong with the record itself comes with a remedy of its own.
    if (u.shape == Shape::unknown &&
        std::any_of(d.data.begin(), d.data.end(), [&](const DataFinding& f) { return f.joint == u.joint; }))
      continue;
    const std::string advice = u.next.empty() ? shape_advice(u.shape) : u.next;
    if (std::find(seen.begin(), seen.end(), advice) != seen.end()) continue;
    seen.push_back(advice);
    out.push_back(shown(u.joint) + ": " + advice);
  }
  return out;
}

std::string data_section(const DiagnosisReport& r, const Style& style) {
  std::string out;
  for (const DataFinding& f : r.diagnosis.data) {
    out += "  " + place_of(f) + ": " + escaped(f.what) + '\n';
    if (!f.remedy.empty()) out += "    remedy: " + escaped(f.remedy) + '\n';
  }
  return out.empty() ? "" : heading("The record itself", style) + out;
}

std::string remainder_section(const DiagnosisReport& r, const Style& style) {
  const Diagnosis& d = r.diagnosis;
  std::string out;
  for (const std::string& line : remainder_lines(d)) out += "  " + line + '\n';
  for (const Unidentified& u : d.unexplained)
    out += "  " + shown(u.joint) + ": " + shape_words(r.spec, u) + '\n' +
           curve_picture(r.spec, u.joint, u.curve, style);
  return out.empty() ? "" : heading("What remains", style) + out;
}

std::string next_section(const DiagnosisReport& r, const Style& style) {
  std::string out;
  for (const std::string& line : advice_lines(r.diagnosis)) out += "  " + line + '\n';
  return out.empty() ? "" : heading("What to do next", style) + out;
}

}  // namespace qerr
