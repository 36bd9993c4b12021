#include <algorithm>

#include "core/text.hpp"
#include "qerr/report/comparison.hpp"
#include "qerr/report/write.hpp"
#include "report/analysis/figures.hpp"
#include "report/analysis/tables.hpp"
#include "report/compare/parts.hpp"
#include "report/formats.hpp"
#include "report/page/page.hpp"
#include "report/text_table.hpp"

/// The page of `qerr check`, of one spec or of a fleet.
namespace qerr {

namespace {

using Result = In<RequirementResult, SpecCheck>;

Requirement requirement(const Result& r) {
  const Spec& spec = r.whole.analysis.spec;
  Requirement of = spec.requirements[r.i];
  if (of.limits_error()) of.unit = name_of(spec, of).unit;
  return of;
}

std::optional<ReportedProof> proof_of_result(const Result& r) {
  return r->proven ? std::optional(ReportedProof{*r->proven, r.whole.analysis.spec}) : std::nullopt;
}

std::string required(const JudgedRequirement& r) { return r.figure.name(); }

using Regression = In<FigureChange, BaselineCheck>;

std::string table_of(const SpecCheck& check, const Style& style) {
  TableRows rows;
  for (std::size_t i = 0; i < check.results.size(); ++i) {
    const Requirement& r = check.analysis.spec.requirements[i];
    const RequirementResult& result = check.results[i];
    rows.push_back({shortened(r.quantity, 32) + (r.statistic.empty() ? "" : ' ' + r.statistic),
                    value_text(r, result.value), relation(r.at_least, result.met), readable(r.limit, r.unit),
                    result.met         ? "met"
                    : result.undecided ? "NOT PROVEN"
                                       : "NOT MET"});
  }
  const std::vector<std::string> lines = aligned_lines(rows);
  std::string out;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const RequirementResult& result = check.results[i];
    out += (result.met ? lines[i] : painted(lines[i], Paint::red, style)) + '\n';
    if (!result.met && !check.analysis.spec.requirements[i].at_least && result.at_max.size() > 0)
      out += wrapped("largest at " + configuration_text(check.analysis.spec.model.chain, result.at_max),
                     style.width, "      ");
    if (result.undecided)
      out += wrapped("between " + readable(result.proven->lower, check.analysis.spec.requirements[i].unit) +
                         ", which is reached, and the proven bound: " + std::string(undecided_remedy),
                     style.width, "      ");
  }
  return out;
}

std::string baseline_table(const BaselineCheck& b, const Style& style) {
  const std::vector<FigureChange> worst = b.worst_by_quantity();
  const std::size_t shown_rows = std::min(worst.size(), most_regressions);
  std::string out = wrapped("Baseline: " + verdict(b), style.width);
  TableRows rows{{"figure", "baseline", "now", "change"}};
  for (std::size_t i = 0; i < shown_rows; ++i)
    rows.push_back({shown(worst[i].figure.name()), readable(*worst[i].a, worst[i].figure.unit),
                    readable(*worst[i].b, worst[i].figure.unit), change_text(worst[i])});
  if (shown_rows > 0) out += fitted_table(rows, style.width);
  if (shown_rows < b.regressions.size())
    out += wrapped("and " + counted(b.regressions.size() - shown_rows, "more figure") + ": --format json",
                   style.width, "  ");
  for (const JudgedRequirement& r : b.dropped_requirements)
    out += wrapped("the baseline requires " + shown(r.figure.name()) + ", which the spec does not",
                   style.width, "  ");
  for (const NamedFigure& f : b.not_in_baseline)
    out += wrapped("the baseline has no " + shown(f.name()) + ", which the spec requires: it is not compared",
                   style.width, "  ");
  if (!b.missing.empty())
    out += wrapped("the spec lacks " + counted(b.missing.size(), "figure") + " of the baseline, such as " +
                       shown(b.missing.front().name()),
                   style.width, "  ");
  return out;
}

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
  std::ranges::stable_sort(rows, [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<std::string> heads{
      "spec", "verdict", "met", "tightest", "takes of its limit", "worse than the baseline"};
  if (std::ranges::none_of(report.specs, [](const SpecCheck& check) { return check.baseline.has_value(); }))
    heads.pop_back();
  TableRows cells;
  for (auto& [order, row] : rows) {
    row.resize(heads.size());
    cells.push_back(std::move(row));
  }
  return page::table(heads, cells);
}

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
  ItemGroups all;
  for (const SpecCheck& check : report.specs)
    for (const std::string& warning : check.analysis.warnings)
      add_to_group(all, warning, check.analysis.spec.file);
  std::vector<std::string> texts;
  for (const auto& [warning, files] : all)
    texts.push_back((files.size() > 1 && files.size() == report.specs.size() ? "all specs" : joined(files)) +
                    ": " + warning);
  return texts;
}

}  // namespace

bool SpecCheck::all_met() const {
  return std::ranges::all_of(results, &RequirementResult::met) &&
         (!baseline || baseline->regressions.empty());
}

SpecCheck check(const Spec& spec, const WorkspaceOptions& options, const Baseline* baseline,
                const ProofRequest& proofs) {
  if (spec.requirements.empty() && !baseline)
    throw spec_error(spec, "requirements", "the spec has none: there is nothing to check", "",
                     "add `requirements:` (see `qerr schema` and `qerr list statistics`), or compare with an "
                     "earlier report: --baseline OLD.json");
  SpecCheck report = evaluate(spec, options, proofs);
  if (!baseline) return report;
  report.baseline = against(*baseline, named_figures(report));
  append(report.analysis.warnings, report.baseline->warnings);
  return report;
}

bool CheckReport::all_met() const {
  return broken.empty() && std::ranges::all_of(specs, &SpecCheck::all_met);
}

std::string verdict(const BaselineCheck& b) {
  const std::string tolerance = b.tolerance > 0 ? " by more than " + percent(b.tolerance) : "";
  return (b.regressions.empty() ? "none" : std::to_string(b.regressions.size())) + " of " +
         counted(b.compared, "figure") + " worse than in " + b.file + tolerance;
}

std::string verdict(const FigureChange& c) {
  return c.figure.name() + " was " + readable(*c.a, c.figure.unit) + " and is " +
         readable(*c.b, c.figure.unit) + " (" + change_text(c) + ")";
}

std::string to_csv(const CheckReport& report, const Style&) {
  std::string out = "quantity,statistic,at_most,value,unit,met,at_least,spec,baseline\r\n";
  for (const SpecCheck& check : report.specs)
    for (std::size_t i = 0; i < check.results.size(); ++i) {
      const Requirement& r = check.analysis.spec.requirements[i];
      const auto limit = [&](bool wanted) { return wanted ? csv_number(r.limit) : std::string(); };
      out += csv_cell(r.quantity) + ',' + r.statistic + ',' + limit(!r.at_least) + ',' +
             csv_number(check.results[i].value) + ',' + r.unit + ',' +
             (check.results[i].met ? "true" : "false") + ',' + limit(r.at_least) + ',' +
             csv_cell(check.analysis.spec.file) + ",\r\n";
    }
  for (const SpecCheck& check : report.specs)
    if (check.baseline)
      for (const FigureChange& c : check.baseline->regressions)
        out += csv_cell(c.figure.quantity) + ',' + c.figure.statistic + ",," + csv_number(c.b) + ',' +
               c.figure.unit + ",false,," + csv_cell(check.analysis.spec.file) + ',' + csv_number(c.a) +
               "\r\n";
  return out;
}

RowsOf<Result> rows(Of<Result>) {
  return requirement_rows<Result>(requirement, "absent for a figure of a filter", "either this or at_least",
                                  "")
      .with({{"proven", proof_of_result, "of the statistic proven_max", optional}});
}

RowsOf<BaselineCheck> rows(Of<BaselineCheck>) {
  return {{"file", &BaselineCheck::file},
          {"tolerance", &BaselineCheck::tolerance, "relative"},
          {"compared", &BaselineCheck::compared, "figures that both have"},
          {"missing", [](auto& b) { return each(b.missing, &NamedFigure::name); },
           "figures that only the baseline has"},
          {"dropped_requirements", [](auto& b) { return each(b.dropped_requirements, required); },
           "that only the baseline has"},
          {"not_in_baseline", [](auto& b) { return each(b.not_in_baseline, &NamedFigure::name); },
           "required figures that it lacks"}};
}

RowsOf<Regression> rows(Of<Regression>) {
  return {{"quantity", [](auto& c) { return c->figure.quantity; }},
          {"statistic", [](auto& c) { return c->figure.statistic; }, "empty: a figure of a filter"},
          {"unit", [](auto& c) { return c->figure.unit; }},
          {"baseline", &FigureChange::a, "null: unbounded"},
          {"value", &FigureChange::b, "null: unbounded"},
          {"change", &FigureChange::relative, "relative; null: from zero, or to unbounded", nullable}};
}

RowsOf<SpecCheck> rows(Of<SpecCheck>) {
  return analysis_header<SpecCheck>("check", [](const SpecCheck& c) -> const Analysis& { return c.analysis; })
      .with({{"requirements", within(&SpecCheck::results)},
             {"baseline", &SpecCheck::baseline, "with --baseline", optional},
             {"regressions",
              [](auto& c) {
                const auto regressions = within(&BaselineCheck::regressions);
                return c.baseline ? std::optional(regressions(*c.baseline)) : std::nullopt;
              },
              "with --baseline: figures that are worse", optional},
             {"met", &SpecCheck::all_met, "all requirements, and no figure is worse"},
             {"warnings", [](auto& c) { return c.analysis.warnings; }}});
}

RowsOf<BrokenSpec> rows(Of<BrokenSpec>) {
  return {{"file", &BrokenSpec::file}, {"error", [](auto& b) { return b.error.what(); }}};
}

RowsOf<CheckReport> rows(Of<CheckReport>) {
  return header<CheckReport>("check").with(
      {{"reports", &CheckReport::specs, "one for each spec, if there are several"},
       {"broken", &CheckReport::broken, "specs that cannot be checked"},
       {"met", &CheckReport::all_met, "all of all"}});
}

std::string to_table(const CheckReport& report, const Style& style) {
  std::string out;
  std::size_t failed = 0, count = 0, worse = 0;
  const bool several = report.specs.size() + report.broken.size() > 1;
  for (const SpecCheck& check : report.specs) {
    if (several) out += painted(shown(check.analysis.spec.file), Paint::bold, style) + '\n';
    out += table_of(check, style);
    if (check.baseline) {
      out += baseline_table(*check.baseline, style);
      worse += check.baseline->regressions.size();
    }
    for (const RequirementResult& result : check.results) failed += !result.met;
    count += check.results.size();
  }
  for (const BrokenSpec& b : report.broken)
    out += painted(shown(b.file), Paint::bold, style) + "\n" +
           painted("  cannot be checked", Paint::red, style) + '\n';
  if (worse > 0)
    out += painted(counted(worse, "figure") + " worse than in the baseline", Paint::red, style) + '\n';
  if (count == 0) return out;
  const std::string all = counted(count, "requirement");
  const std::string unchecked =
      report.broken.empty()
          ? ""
          : painted(counted(report.broken.size(), "spec") + " not checked", Paint::red, style) + '\n';
  return out + unchecked +
         (failed ? painted(std::to_string(failed) + " of " + all + " not met", Paint::red, style)
                 : painted(all + " met", Paint::green, style)) +
         '\n';
}

page::Page page_of(const CheckReport& report) {
  page::Page page{title_of(report), answer_of(report), {}};
  const bool fleet = report.specs.size() + report.broken.size() > 1;
  if (fleet) {
    page.about = fleet_block(report);
    page.add("All specs", fleet_table(report));
    page.warnings = shared_warnings(report);
  } else {
    const SpecCheck& only = report.specs.front();
    describe(page, only.analysis.spec, only.results);
    page.warnings = only.analysis.warnings;
  }
  for (const BrokenSpec& b : report.broken)
    page.add(shown(b.file), page::paragraph("It cannot be checked: " + std::string(b.error.what())));
  for (const SpecCheck& check : report.specs) {
    const Spec& spec = check.analysis.spec;
    const std::string body = (fleet ? page::title_block(spec, check.results) : "") +
                             (check.baseline ? baseline_of_page(*check.baseline) : "");
    page.add(fleet ? shown(spec.file) : "Baseline", body);
  }
  return page;
}

}  // namespace qerr
