#include <algorithm>
#include <cmath>
#include <set>

#include "core/text.hpp"
#include "qerr/core/error.hpp"
#include "qerr/report/analysis.hpp"
#include "qerr/report/comparison.hpp"
#include "report/compare/parts.hpp"

namespace qerr {

namespace {

bool has_limit(const NamedFigures& report, const NamedFigure& f, bool at_least) {
  return std::any_of(report.requirements.begin(), report.requirements.end(), [&](const JudgedRequirement& r) {
    return r.figure.quantity == f.quantity && r.figure.statistic == f.statistic && r.at_least == at_least;
  });
}

/// A figure is worse if it is larger; one that is required to be large, if it is smaller; one with limits on
/// both sides in either case.
bool is_worse(const FigureChange& c, double tolerance, const NamedFigures& old, const NamedFigures& now) {
  const auto limited = [&](bool at_least) {
    return has_limit(old, c.figure, at_least) || has_limit(now, c.figure, at_least);
  };
  if (c.relative > tolerance) return limited(false) || !limited(true);
  return c.relative < -tolerance && limited(true);
}

}  // namespace

Baseline read_baseline(const std::string& text, const std::string& file, double tolerance) {
  Baseline baseline{read_named_figures(text, file), tolerance};
  if (baseline.figures.command == "filter")
    throw Error(Fault{{file},
                      "command",
                      "a baseline must be a report of check or analyze",
                      quoted(baseline.figures.command),
                      "write one with: qerr check SPEC -o OLD.json, or qerr analyze SPEC -o OLD.json"});
  return baseline;
}

BaselineCheck against(const Baseline& baseline, const NamedFigures& now) {
  const NamedFigures& old = baseline.figures;
  BaselineCheck check{old.file, baseline.tolerance, 0, {}, {}, {}, comparison_warnings(old, now)};
  for (const FigureChange& c : figure_changes(old, now)) {
    check.compared += c.in_both();
    if (!c.b) check.missing.push_back(c.figure);
    if (c.in_both() && is_worse(c, baseline.tolerance, old, now)) check.regressions.push_back(c);
  }
  if (check.compared == 0)
    throw Error(Fault{{old.file},
                      "",
                      "the baseline has none of the figures of " + quoted(now.file),
                      check.missing.empty() ? "no figure" : counted(check.missing.size(), "other figure"),
                      "write it anew with the same coordinates and filters: qerr analyze SPEC -o OLD.json"});
  for (const JudgedRequirement& r : old.requirements)
    if (std::none_of(now.requirements.begin(), now.requirements.end(),
                     [&](const JudgedRequirement& other) { return same_limit(r, other); }))
      check.dropped_requirements.push_back(r);
  return check;
}

std::vector<FigureChange> BaselineCheck::worst_by_quantity() const {
  std::set<std::string> with_main, seen;
  for (const FigureChange& c : regressions)
    if (is_main(c.figure)) with_main.insert(c.figure.quantity);
  std::vector<FigureChange> worst;
  for (const FigureChange& c : regressions)
    if ((is_main(c.figure) || !with_main.contains(c.figure.quantity)) &&
        seen.insert(c.figure.quantity).second)
      worst.push_back(c);
  return worst;
}

}  // namespace qerr
