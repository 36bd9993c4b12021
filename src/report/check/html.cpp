#include <algorithm>
#include <cmath>

#include "report/analysis/about.hpp"
#include "report/analysis/requirements.hpp"
#include "report/check/parts.hpp"
#include "report/compare/parts.hpp"
#include "report/formats.hpp"
#include "report/page/bars.hpp"
#include "report/page/page.hpp"
#include "report/page/prose.hpp"
#include "report/text_table.hpp"

/// The page of `qerr check`, of one spec or of a fleet.
namespace qerr {

namespace {

std::string word_of(const RequirementResult& r) {
  return r.met ? "met" : r.undecided ? "not proven" : "NOT MET";
}

std::string title_of(const CheckReport& report) {
  const std::size_t count = report.specs.size() + report.broken.size();
  return count == 1 && report.broken.empty()
             ? "Requirements of " + shown(report.specs.front().analysis.spec.robot_name)
             : "Requirements of " + counted(count, "spec");
}

/// One sentence for a design review: how many are met, and which is worst.
std::string answer_of(const CheckReport& report) {
  std::size_t all = 0, met = 0, worse = 0;
  const Requirement* tightest = nullptr;
  std::string where;
  double largest = -1;
  for (const SpecCheck& check : report.specs) {
    worse += check.baseline ? check.baseline->regressions.size() : 0;
    for (std::size_t i = 0; i < check.results.size(); ++i) {
      const Requirement& r = check.analysis.spec.requirements[i];
      ++all, met += check.results[i].met;
      if (const auto part = part_of_limit(r, check.results[i]); part && *part > largest)
        largest = *part, tightest = &r, where = check.analysis.spec.file;
    }
  }
  std::string text = met == all
                         ? "All " + counted(all, "requirement") + " are met"
                         : std::to_string(all - met) + " of " + counted(all, "requirement") + " are not met";
  if (tightest)
    text += "; the tightest, " + limited(*tightest) + (report.specs.size() > 1 ? " of " + shown(where) : "") +
            ", takes " + percent(largest) + " of its limit";
  if (worse > 0) text += "; " + counted(worse, "figure") + " worse than in the baseline";
  if (!report.broken.empty()) text += "; " + counted(report.broken.size(), "spec") + " cannot be checked";
  return text + '.';
}

std::string results_of(const SpecCheck& check) {
  const Spec& spec = check.analysis.spec;
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < check.results.size(); ++i) {
    const Requirement& r = spec.requirements[i];
    const RequirementResult& result = check.results[i];
    const bool located = !r.at_least && result.at_max.size() > 0;
    rows.push_back({limited(r), word_of(result), readable(result.value, r.unit), margin_text(r, result),
                    located ? largest_place(check.analysis, result.at_max) : ""});
  }
  const page::Bars bars = page::use_of_limits(spec.requirements, check.results);
  return (bars.bars.size() == 1 ? "" : page::side_by_side(figure(bars))) +
         page::isolated_table({"requirement", "verdict", "value", "margin", "configuration"}, rows);
}

std::string baseline_of_page(const BaselineCheck& b) {
  std::vector<std::vector<std::string>> rows;
  for (const FigureChange& f : b.worst_by_quantity())
    rows.push_back(
        {f.figure.name(), readable(*f.a, f.figure.unit), readable(*f.b, f.figure.unit), change_text(f)});
  return page::paragraph("Baseline: " + verdict(b) + '.') +
         (rows.empty() ? "" : page::isolated_table({"figure", "baseline", "now", "change"}, rows));
}

/// A row for each spec, those that fail first.
std::string fleet_table(const CheckReport& report) {
  std::vector<std::pair<double, std::vector<std::string>>> rows;
  for (const BrokenSpec& b : report.broken) rows.push_back({INFINITY, {b.file, "CANNOT BE CHECKED"}});
  for (const SpecCheck& check : report.specs) {
    std::size_t met = 0, tightest = 0;
    double largest = -1;
    for (std::size_t i = 0; i < check.results.size(); ++i) {
      met += check.results[i].met;
      const auto part = part_of_limit(check.analysis.spec.requirements[i], check.results[i]);
      if (part && *part > largest) largest = *part, tightest = i;
    }
    const std::size_t all = check.results.size();
    rows.push_back({check.all_met() ? largest : 1e9 + largest,
                    {check.analysis.spec.file, check.all_met() ? "met" : "NOT MET",
                     std::to_string(met) + " of " + std::to_string(all),
                     largest < 0 ? "" : limited(check.analysis.spec.requirements[tightest]),
                     largest < 0 ? "" : percent(largest),
                     check.baseline ? std::to_string(check.baseline->regressions.size()) : ""}});
  }
  std::stable_sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<std::string> heads{
      "spec", "verdict", "met", "tightest", "takes of its limit", "worse than the baseline"};
  if (std::none_of(report.specs.begin(), report.specs.end(),
                   [](const SpecCheck& check) { return check.baseline.has_value(); }))
    heads.pop_back();
  std::vector<std::vector<std::string>> cells;
  for (auto& [order, row] : rows) {
    row.resize(heads.size());
    cells.push_back(std::move(row));
  }
  return page::isolated_table(heads, cells);
}

}  // namespace

std::string to_html(const CheckReport& report, const Style&) {
  page::Page page{title_of(report), answer_of(report), {}};
  const bool fleet = report.specs.size() + report.broken.size() > 1;
  if (fleet) page.sections.push_back({"All specs", fleet_table(report)});
  for (const BrokenSpec& b : report.broken)
    page.sections.push_back(
        {shown(b.file), page::paragraph("It cannot be checked: " + std::string(b.error.what()))});
  for (const SpecCheck& check : report.specs) {
    const Spec& spec = check.analysis.spec;
    page.sections.push_back({fleet ? shown(spec.file) : "Requirements",
                             results_of(check) + (check.baseline ? baseline_of_page(*check.baseline) : "")});
    for (const std::string& warning : check.analysis.warnings)
      if (const std::string text = fleet ? spec.file + ": " + warning : warning;
          std::find(page.warnings.begin(), page.warnings.end(), text) == page.warnings.end())
        page.warnings.push_back(text);
  }
  if (!fleet) page::describe(page, report.specs.front().analysis.spec, report.specs.front().results);
  return markup(page);
}

}  // namespace qerr
