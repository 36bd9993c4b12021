#include "core/text.hpp"
#include "report/diagnosis/sections.hpp"
#include "report/diagnosis/sentences.hpp"
#include "report/formats.hpp"
#include "report/text_table.hpp"
#include "report/wrapped_text.hpp"

namespace qerr {

namespace {

std::string verdict_line(const DiagnosisReport& r, const Style& style) {
  const Diagnosis& d = r.diagnosis;
  return painted(verdict_title(d), is_faultless(d) ? Paint::green : Paint::yellow, style) + ": " +
         verdict_words(r) + "\n";
}

}  // namespace

std::string record_words(const Log& log) {
  std::string out = "'" + escaped(log.file) + "': " + counted(log.rows, "row");
  if (log.has_time()) out += " over " + significant(log.last_time - log.first_time, 4) + " s";
  for (const LogColumn& c : log.columns)
    if (c.wraps.count > 0 || c.wraps.start != 0)
      out += "\n  unwrapped: " + escaped(c.header) + ", " + counted(c.wraps.count, "full turn") +
             (c.wraps.start ? ", " + std::to_string(c.wraps.start) + " at the start" : "");
  return out;
}

std::string to_table(const DiagnosisReport& r, const Style& style) {
  std::string out = painted("qerr diagnose", Paint::bold, style) + "  robot '" +
                    escaped(r.spec.robot_name, 60) + "', " + record_words(r.log) + "\n\n" +
                    verdict_line(r, style);
  out += data_section(r, style) + causes_section(r, style) + remainder_section(r, style) +
         next_section(r, style) + visible_section(r, style);
  if (style.details) out += details_section(r, style);
  if (!r.extended_model.empty()) out += "\nExtended model: " + escaped(r.extended_model) + '\n';
  return within(out, style.width);
}

}  // namespace qerr
