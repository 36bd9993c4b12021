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

/// A figure is worse if it is larger, or smaller where a larger one is better; one that is required to be
/// large, if it is smaller; one with limits on both sides in either case.
bool is_worse(const FigureChange& c, double tolerance, const NamedFigures& old, const NamedFigures& now) {
  const auto limited = [&](bool at_least) {
    return has_limit(old, c.figure, at_least) || has_limit(now, c.figure, at_least);
  };
  if (c.figure.larger_is_better && !limited(false)) return c.relative < -tolerance;
  if (c.relative > tolerance) return limited(false) || !limited(true);
  return c.relative < -tolerance && limited(true);
}

}  // namespace

Baselines read_baselines(const std::string& text, const std::string& file, double tolerance) {
  Baselines baselines;
  for (NamedFigures& figures : read_all_named_figures(text, file)) {
    if (figures.command == "filter")
      throw Error(Fault{{file},
                        "command",
                        "a baseline must be a report of check or analyze",
                        quoted(figures.command),
                        "write one with: qerr check SPEC -o OLD.json, or qerr analyze SPEC -o OLD.json"});
    baselines.push_back({std::move(figures), tolerance});
  }
  return baselines;
}

const Baseline& baseline_of(const Baselines& baselines, const std::string& spec, bool alone) {
  if (baselines.size() == 1 && alone) return baselines.front();
  // A spec may have moved with its folder: its name then identifies it, where only one has it.
  const auto name = [](const std::string& path) { return path.substr(path.rfind('/') + 1); };
  const Baseline* found = nullptr;
  std::size_t named = 0;
  for (const Baseline& b : baselines) {
    if (b.figures.spec == spec) return b;
    if (name(b.figures.spec) != name(spec)) continue;
    found = &b;
    ++named;
  }
  if (found && named == 1) return *found;
  std::string specs;
  for (const Baseline& b : baselines) specs += (specs.empty() ? "" : ", ") + quoted(b.figures.spec);
  throw Error(Fault{{baselines.empty() ? "" : baselines.front().figures.file},
                    "reports",
                    "the baseline has no report of " + quoted(spec),
                    specs.empty() ? "no report" : "reports of " + specs,
                    "write it anew with all specs: qerr check SPEC... --format json -o OLD.json"});
}

BaselineCheck against(const Baseline& baseline, const NamedFigures& now) {
  const NamedFigures& old = baseline.figures;
  if (old.robot != now.robot && !old.robot.empty() && !now.robot.empty())
    throw Error(Fault{{old.file},
                      "robot",
                      "the baseline is that of another robot or chain than " + quoted(now.file),
                      quoted(old.robot) + ", here " + quoted(now.robot),
                      "write it anew: qerr check SPEC -o OLD.json"});
  BaselineCheck check{old.file, baseline.tolerance, 0, {}, {}, {}, {}, comparison_warnings(old, now)};
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
  for (const JudgedRequirement& r : now.requirements)
    if (!find_figure(old, r.figure) &&
        std::none_of(old.requirements.begin(), old.requirements.end(),
                     [&](const JudgedRequirement& other) { return other.figure.name() == r.figure.name(); }))
      check.not_in_baseline.push_back(r.figure);
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
