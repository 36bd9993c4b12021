#include <utility>

#include "report/diagnosis/page/pictures.hpp"
#include "report/diagnosis/sections.hpp"
#include "report/diagnosis/sentences.hpp"
#include "report/formats.hpp"
#include "report/page/page.hpp"
#include "report/page/prose.hpp"

namespace qerr {

namespace {

/// A page stays below 300 kB: what the other parts, style and script leave is for the lines of the record.
std::size_t bytes_of_residuals(const page::Page& others) {
  constexpr std::size_t page = 285000, style_and_script = 14000, fewest = 40000;
  std::size_t taken = style_and_script + others.spec_text.size();
  for (const page::Section& s : others.sections) taken += s.body.size();
  for (const std::string& w : others.warnings) taken += w.size();
  return page > taken + fewest ? page - taken : fewest;
}

}  // namespace

std::string to_html(const DiagnosisReport& r, const Style&) {
  const Diagnosis& d = r.diagnosis;
  page::Page page{"Diagnosis of " + r.spec.robot_name,
                  page::isolated_runs(verdict_title(d.verdict) + ": " + verdict_words(r) + "."),
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
  const auto before_and_after = static_cast<std::ptrdiff_t>(page.sections.size());
  add("What remains", remainder_part(r));
  add("What the record would have shown", visible_part(r));
  add("Gain", gain_part(r));
  if (std::string residuals = residuals_part(r, bytes_of_residuals(page)); !residuals.empty())
    page.sections.insert(page.sections.begin() + before_and_after,
                         {"Before and after", std::move(residuals)});
  return markup(page);
}

}  // namespace qerr
