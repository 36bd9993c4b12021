#include <algorithm>

#include "report/diagnosis/page/pictures.hpp"
#include "report/diagnosis/sections.hpp"
#include "report/diagnosis/sentences.hpp"
#include "report/formats.hpp"
#include "report/page/page.hpp"
#include "report/page/prose.hpp"

namespace qerr {

namespace {

/// Points of all lines of a page below 300 kB, at about 35 bytes each, beside its text.
constexpr std::size_t most_points = 6000;

/// Of the record's lines: what the curves of causes and of what remains leave. A mark takes five points'
/// bytes.
std::size_t points_of_residuals(const Diagnosis& d) {
  constexpr std::size_t per_mark = 5, per_line = 1, fewest = 600;
  std::size_t taken = 0;
  for (const Cause& c : d.causes) taken += (per_mark + per_line) * c.curve.at.size();
  for (const Unidentified& u : d.unexplained) taken += (per_mark + per_line) * u.curve.at.size();
  return std::max(fewest, most_points - std::min(most_points, taken));
}

}  // namespace

std::string to_html(const DiagnosisReport& r, const Style&) {
  const Diagnosis& d = r.diagnosis;
  page::Page page{"Diagnosis of " + r.spec.robot_name,
                  verdict_title(d.verdict) + ": " + verdict_words(r) + ".",
                  {},
                  r.warnings,
                  r.spec.file,
                  r.spec.text};
  const auto add = [&](const std::string& heading, const std::string& body) {
    if (!body.empty()) page.sections.push_back({heading, body});
  };
  add("The record", page::paragraph(record_words(r.log) + "."));
  add("Faults of the record itself", record_part(r));
  add("Causes", causes_part(r));
  add("Sizes of the causes", parameters_part(r));
  add("Before and after", residuals_part(r, points_of_residuals(d)));
  add("What remains", remainder_part(r));
  add("What the record would have shown", visible_part(r));
  add("Gain", gain_part(r));
  return markup(page);
}

}  // namespace qerr
