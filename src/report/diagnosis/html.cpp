#include <algorithm>
#include <utility>

#include "report/analysis/about.hpp"
#include "report/analysis/requirements.hpp"
#include "report/diagnosis/page/pictures.hpp"
#include "report/diagnosis/sections.hpp"
#include "report/diagnosis/sentences.hpp"
#include "report/formats.hpp"
#include "report/page/page.hpp"
#include "report/page/prose.hpp"

namespace qerr {

namespace {

/// Lines of a terminal's table as clauses of a sentence.
std::string in_one_line(const std::string& lines) {
  std::string out;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (lines[i] != '\n') {
      out += lines[i];
      continue;
    }
    out += "; ";
    i = std::min(lines.find_first_not_of(' ', i + 1), lines.size()) - 1;
  }
  return out;
}

}  // namespace

page::Page page_of(const DiagnosisReport& r) {
  const Diagnosis& d = r.diagnosis;
  page::Page page{"Diagnosis of " + r.spec.robot_name,
                  page::isolated_runs(verdict_title(d) + ": " + verdict_words(r) + "."),
                  {},
                  r.warnings};
  describe(page, r.spec, verdicts_beside(r.spec));
  const auto add = [&](const std::string& heading, const std::string& body) {
    if (!body.empty()) page.sections.push_back({heading, body});
  };
  add("Causes", causes_part(r));
  add("Sizes of the causes", parameters_part(r));
  add("What to record next", next_part(r));
  const auto before_and_after = static_cast<std::ptrdiff_t>(page.sections.size());
  add("What remains", remainder_part(r));
  add("What the record would have shown", visible_part(r));
  add("Gain", gain_part(r));
  add("The record", page::paragraph(in_one_line(record_words(r.log)) + "."));
  add("Faults of the record itself", record_part(r));
  if (std::string residuals = residuals_part(r, page::bytes_left(page)); !residuals.empty())
    page.sections.insert(page.sections.begin() + before_and_after,
                         {"Before and after", std::move(residuals)});
  return page;
}

}  // namespace qerr
