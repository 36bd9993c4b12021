#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "qerr/report/write.hpp"
#include "report/analysis/about.hpp"
#include "report/analysis/requirements.hpp"
#include "report/check/parts.hpp"
#include "report/compare/parts.hpp"
#include "report/formats.hpp"
#include "report/page/markup.hpp"
#include "report/page/page.hpp"
#include "report/text_table.hpp"

/// The page of `qerr check`, of one spec or of a fleet.
namespace qerr {

namespace {

std::string title_of(const CheckReport& report) {
  const std::size_t count = report.specs.size() + report.broken.size();
  return count == 1 && report.broken.empty()
             ? "Requirements of " + shown(report.specs.front().analysis.spec.robot_name)
             : "Requirements of " + counted(count, "spec");
}

/// How many requirements of a spec are met, and which takes the largest part of its limit.
struct Tightest {
  std::size_t met = 0;
  std::string requirement = {};  ///< "": no part is known
  double part = -1;
};

Tightest tightest_of(const SpecCheck& check) {
  Tightest t;
  for (std::size_t i = 0; i < check.results.size(); ++i) {
    const Requirement& r = check.analysis.spec.requirements[i];
    t.met += check.results[i].met;
    if (const auto part = part_of_limit(r, check.results[i]); part && *part > t.part)
      t.part = *part, t.requirement = limited(r);
  }
  return t;
}

/// One sentence for a design review: how many are met, and which is worst.
std::string answer_of(const CheckReport& report) {
  std::size_t all = 0, met = 0, worse = 0;
  Tightest tightest;
  std::string where;
  for (const SpecCheck& check : report.specs) {
    worse += check.baseline ? check.baseline->regressions.size() : 0;
    const Tightest t = tightest_of(check);
    all += check.results.size(), met += t.met;
    if (t.part > tightest.part) tightest = t, where = check.analysis.spec.file;
  }
  std::string text = met == all
                         ? "All " + counted(all, "requirement") + " are met"
                         : std::to_string(all - met) + " of " + counted(all, "requirement") + " are not met";
  if (tightest.part >= 0)
    text += "; the tightest, " + tightest.requirement +
            (report.specs.size() > 1 ? " of " + shown(where) : "") + ", takes " + percent(tightest.part) +
            " of its limit";
  if (worse > 0) text += "; " + counted(worse, "figure") + " worse than in the baseline";
  if (!report.broken.empty()) text += "; " + counted(report.broken.size(), "spec") + " cannot be checked";
  return text + '.';
}

std::string baseline_of_page(const BaselineCheck& b) {
  TableRows rows;
  for (const FigureChange& f : b.worst_by_quantity())
    rows.push_back(
        {f.figure.name(), readable(*f.a, f.figure.unit), readable(*f.b, f.figure.unit), change_text(f)});
  return page::paragraph("Baseline: " + verdict(b) + '.') +
         (rows.empty() ? "" : page::table({"figure", "baseline", "now", "change"}, rows));
}

/// A row for each spec, those that fail first.
std::string fleet_table(const CheckReport& report) {
  std::vector<std::pair<double, std::vector<std::string>>> rows;
  for (const BrokenSpec& b : report.broken) rows.push_back({INFINITY, {b.file, "CANNOT BE CHECKED"}});
  for (const SpecCheck& check : report.specs) {
    const Tightest t = tightest_of(check);
    rows.push_back({check.all_met() ? t.part : 1e9 + t.part,
                    {check.analysis.spec.file, check.all_met() ? "met" : "NOT MET",
                     std::to_string(t.met) + " of " + std::to_string(check.results.size()), t.requirement,
                     t.part < 0 ? "" : percent(t.part),
                     check.baseline ? std::to_string(check.baseline->regressions.size()) : ""}});
  }
  std::stable_sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<std::string> heads{
      "spec", "verdict", "met", "tightest", "takes of its limit", "worse than the baseline"};
  if (std::none_of(report.specs.begin(), report.specs.end(),
                   [](const SpecCheck& check) { return check.baseline.has_value(); }))
    heads.pop_back();
  TableRows cells;
  for (auto& [order, row] : rows) {
    row.resize(heads.size());
    cells.push_back(std::move(row));
  }
  return page::table(heads, cells);
}

/// What all specs of a fleet have in common.
std::string fleet_block(const CheckReport& report) {
  std::string set;
  if (!report.specs.empty())
    set = joined(report.specs.front().analysis.spec.overrides, ", ",
                 [](const auto& o) { return o.first + '=' + o.second; });
  return page::title_list(
             {{"Specs", std::to_string(report.specs.size() + report.broken.size())},
              {"Changed by --set", page::escaped_markup(set.empty() ? "nothing" : escaped(set, 300))},
              {"Computed by", "qerr " + std::string(version())}}) +
         "</div>\n";
}

/// Each warning once, with the specs that it concerns.
std::vector<std::string> shared_warnings(const CheckReport& report) {
  std::vector<std::pair<std::string, std::vector<std::string>>> all;
  for (const SpecCheck& check : report.specs)
    for (const std::string& warning : check.analysis.warnings) {
      auto at = std::find_if(all.begin(), all.end(), [&](const auto& w) { return w.first == warning; });
      if (at == all.end()) at = all.insert(at, {warning, {}});
      add_once(at->second, check.analysis.spec.file);
    }
  std::vector<std::string> texts;
  for (const auto& [warning, files] : all)
    texts.push_back((files.size() > 1 && files.size() == report.specs.size() ? "all specs" : joined(files)) +
                    ": " + warning);
  return texts;
}

}  // namespace

page::Page page_of(const CheckReport& report) {
  page::Page page{title_of(report), answer_of(report), {}};
  const bool fleet = report.specs.size() + report.broken.size() > 1;
  if (fleet) {
    page.about = fleet_block(report);
    page.sections.push_back({"All specs", fleet_table(report)});
    page.warnings = shared_warnings(report);
  } else {
    const SpecCheck& only = report.specs.front();
    describe(page, only.analysis.spec, only.results);
    page.warnings = only.analysis.warnings;
  }
  for (const BrokenSpec& b : report.broken)
    page.sections.push_back(
        {shown(b.file), page::paragraph("It cannot be checked: " + std::string(b.error.what()))});
  for (const SpecCheck& check : report.specs) {
    const Spec& spec = check.analysis.spec;
    const std::string body = (fleet ? page::title_block(spec, check.results) : "") +
                             (check.baseline ? baseline_of_page(*check.baseline) : "");
    if (!body.empty()) page.sections.push_back({fleet ? shown(spec.file) : "Baseline", body});
  }
  return page;
}

}  // namespace qerr
