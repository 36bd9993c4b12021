#include "qerr/report/comparison.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "core/lists.hpp"
#include "core/text.hpp"
#include "qerr/core/error.hpp"
#include "qerr/report/analysis.hpp"
#include "report/analysis/figures.hpp"
#include "report/compare/parts.hpp"

namespace qerr {

namespace {

Error report_error(const std::string& file, const std::string& key, const std::string& rule,
                   const std::string& found, const std::string& remedy) {
  return Error({file}, key, rule, found, remedy);
}

/// Reports of analyze and of check have the same figures, those of filter others; a spec has all.
bool comparable(const NamedFigures& a, const NamedFigures& b) {
  const auto all = [](const NamedFigures& f) { return f.command == "spec"; };
  return all(a) || all(b) || (a.command == "filter") == (b.command == "filter");
}

void require_comparable(const NamedFigures& a, const NamedFigures& b) {
  if (!comparable(a, b))
    throw report_error(b.file, "command", "both reports must be of one command",
                       quoted(b.command) + ", and " + quoted(a.command) + " in " + a.file,
                       "compare the specs, or reports of one command");
}

void require_one_unit(const NamedFigure& a, const NamedFigure& b, const NamedFigures& in_a,
                      const NamedFigures& in_b) {
  if (a.unit == b.unit) return;
  throw report_error(in_b.file, b.quantity, "a figure must have one unit",
                     quoted(b.unit) + ", and " + quoted(a.unit) + " in " + in_a.file,
                     "do both estimate the same derivative? Give different filters different names");
}

/// Of each unit the size below which a figure is the rounding of a zero: a coordinate that no encoder moves
/// has 1e-20 m on one processor and 0 m on another one.
std::map<std::string, double> rounded_zeros(const NamedFigures& a, const NamedFigures& b) {
  constexpr double rounding = 1e-12;  // of the largest figure; sums of some thousand products round to less
  std::map<std::string, double> sizes;
  for (const NamedFigures* report : {&a, &b})
    for (const NamedFigure& f : report->figures)
      if (std::isfinite(f.value)) sizes[f.unit] = std::max(sizes[f.unit], rounding * std::abs(f.value));
  return sizes;
}

/// The largest relative changes first, those of one report only at the end.
/// @throws Error (input) if a figure has two units
std::vector<FigureChange> figure_changes(const NamedFigures& a, const NamedFigures& b) {
  std::map<std::string, double> zeros = rounded_zeros(a, b);
  std::vector<FigureChange> changes;
  std::vector<bool> seen(b.figures.size());
  constexpr double missing = std::numeric_limits<double>::quiet_NaN();
  for (const NamedFigure& f : a.figures) {
    changes.push_back({f, f.value, {}, missing});
    const NamedFigure* other = find_figure(b, f);
    if (!other) continue;
    require_one_unit(f, *other, a, b);
    const auto rounded = [&](double x) { return std::abs(x) <= zeros[f.unit] ? 0 : x; };
    changes.back() = {*other, f.value, other->value,
                      relative_change(rounded(f.value), rounded(other->value))};
    seen[other - b.figures.data()] = true;
  }
  for (std::size_t i = 0; i < seen.size(); ++i)
    if (!seen[i]) changes.push_back({b.figures[i], {}, b.figures[i].value, missing});
  // Figures that are multiples of each other change alike but for rounding, and keep their order.
  const auto size = [](const FigureChange& c) {
    return c.in_both() ? rounded_to(std::abs(c.relative), 9) : -1;
  };
  std::ranges::stable_sort(changes,
                           [&](const FigureChange& x, const FigureChange& y) { return size(x) > size(y); });
  return changes;
}

std::vector<ShareChange> share_changes(const NamedFigures& a, const NamedFigures& b) {
  std::vector<ShareChange> changes;
  for (const EncoderShare& s : a.shares) changes.push_back({s.encoder, s.share, {}});
  for (const EncoderShare& s : b.shares) {
    const auto known =
        std::ranges::find_if(changes, [&](const ShareChange& c) { return c.encoder == s.encoder; });
    if (known == changes.end())
      changes.push_back({s.encoder, {}, s.share});
    else
      known->b = s.share;
  }
  const auto size = [](const ShareChange& c) { return std::abs(c.b.value_or(0) - c.a.value_or(0)); };
  std::ranges::stable_sort(changes,
                           [&](const ShareChange& x, const ShareChange& y) { return size(x) > size(y); });
  return changes;
}

/// Whether both limit the same figure from the same side.
bool same_limit(const JudgedRequirement& a, const JudgedRequirement& b) {
  return same_figure(a.figure, b.figure) && a.at_least == b.at_least;
}

/// Requirements are the same if they limit the same figure from the same side; repeated ones in their order.
std::vector<RequirementChange> requirement_changes(const NamedFigures& a, const NamedFigures& b) {
  std::vector<RequirementChange> changes;
  for (const JudgedRequirement& r : a.requirements) changes.push_back({r, {}});
  for (const JudgedRequirement& r : b.requirements) {
    const auto known = std::ranges::find_if(
        changes, [&](const RequirementChange& c) { return !c.b && same_limit(*c.a, r); });
    if (known == changes.end())
      changes.push_back({{}, r});
    else
      known->b = r;
  }
  // A limit of 0 has no margin; requirements of one report only are last.
  const auto order = [](const RequirementChange& r) {
    if (r.flipped()) return std::pair(0, *r.flips_after());
    const double in_b = r.b ? margin(*r.b) : std::numeric_limits<double>::quiet_NaN();
    return std::pair(r.a && r.b ? 1 : 2, std::isnan(in_b) ? std::numeric_limits<double>::infinity() : in_b);
  };
  std::ranges::stable_sort(
      changes, [&](const RequirementChange& x, const RequirementChange& y) { return order(x) < order(y); });
  return changes;
}

/// What makes the figures of two reports hard to compare.
std::vector<std::string> comparison_warnings(const NamedFigures& a, const NamedFigures& b) {
  std::vector<std::string> warnings;
  const auto differ = [&](const std::string& x, const std::string& y) {
    return !x.empty() && !y.empty() && x != y;
  };
  if (differ(a.robot, b.robot))
    warnings.push_back("the robots differ: " + a.robot + " in A, " + b.robot + " in B");
  if (differ(a.sample, b.sample))
    warnings.push_back("the statistics are of different configurations: " + a.sample + " in A, " + b.sample +
                       " in B; small changes may be those of the sample");
  return warnings;
}

bool has_limit(const NamedFigures& report, const NamedFigure& f, bool at_least) {
  return std::ranges::any_of(report.requirements, [&](const JudgedRequirement& r) {
    return same_figure(r.figure, f) && r.at_least == at_least;
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

double relative_change(double a, double b) {
  // Sums over configurations differ by some 1e-12 between processors: that is no change of a design.
  constexpr double same = 1e-9;
  if (a == b) return 0;
  if (std::isinf(a)) return -1;
  if (a == 0 || std::isinf(b)) return std::copysign(std::numeric_limits<double>::infinity(), b);
  const double change = (b - a) / std::abs(a);
  return std::abs(change) <= same ? 0 : change;
}

double margin(const JudgedRequirement& r) { return margin(r.figure.value, r.limit, r.at_least); }

std::optional<double> RequirementChange::flips_after() const {
  if (!flipped()) return std::nullopt;
  // The limit is B's: where both differ, the requirement that A's figure is compared with changes at once.
  const double from = a->figure.value, to = b->figure.value, limit = b->limit;
  if (!std::isfinite(from)) return 1;  // of what was unbounded, only B is below the limit
  if (!std::isfinite(to) || from == to) return 0;
  return std::clamp((limit - from) / (to - from), 0.0, 1.0);
}

const NamedFigure* find_figure(const NamedFigures& in, const NamedFigure& like) {
  const auto found =
      std::ranges::find_if(in.figures, [&](const NamedFigure& f) { return same_figure(f, like); });
  return found == in.figures.end() ? nullptr : &*found;
}

ReportComparison compare(NamedFigures a, NamedFigures b) {
  require_comparable(a, b);
  ReportComparison c;
  c.figures = figure_changes(a, b);
  c.shares = share_changes(a, b);
  c.requirements = requirement_changes(a, b);
  c.warnings = comparison_warnings(a, b);
  c.a = std::move(a);
  c.b = std::move(b);
  return c;
}

Baselines read_baselines(const std::string& text, const std::string& file, double tolerance) {
  Baselines baselines;
  for (NamedFigures& figures : read_all_named_figures(text, file)) {
    if (figures.command == "filter")
      throw report_error(file, "command", "a baseline must be a report of check or analyze",
                         qerr::quoted(figures.command),
                         "write one with: qerr check SPEC -o OLD.json, or qerr analyze SPEC -o OLD.json");
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
  const std::string specs = joined(baselines, ", ", [](const Baseline& b) { return quoted(b.figures.spec); });
  throw Error({baselines.empty() ? "" : baselines.front().figures.file}, "reports",
              "the baseline has no report of " + quoted(spec),
              specs.empty() ? "no report" : "reports of " + specs,
              "write it anew with all specs: qerr check SPEC... --format json -o OLD.json");
}

BaselineCheck against(const Baseline& baseline, const NamedFigures& now) {
  const NamedFigures& old = baseline.figures;
  if (old.robot != now.robot && !old.robot.empty() && !now.robot.empty())
    throw report_error(
        old.file, "robot", "the baseline is that of another robot or chain than " + quoted(now.file),
        quoted(old.robot) + ", here " + quoted(now.robot), "write it anew: qerr check SPEC -o OLD.json");
  BaselineCheck check{old.file, baseline.tolerance, 0, {}, {}, {}, {}, comparison_warnings(old, now)};
  if (old.changes != now.changes) {
    const auto with = [](const std::vector<std::string>& changes) {
      return changes.empty() ? "no --set" : "--set " + joined(changes, " --set ", shell_word);
    };
    check.warnings.push_back("the baseline is of " + with(old.changes) + ", these figures of " +
                             with(now.changes) + ": they are of different specs");
  }
  for (const FigureChange& c : figure_changes(old, now)) {
    check.compared += c.in_both();
    if (!c.b) check.missing.push_back(c.figure);
    if (c.in_both() && is_worse(c, baseline.tolerance, old, now)) check.regressions.push_back(c);
  }
  if (check.compared == 0)
    throw report_error(old.file, "", "the baseline has none of the figures of " + quoted(now.file),
                       check.missing.empty() ? "no figure" : counted(check.missing.size(), "other figure"),
                       "write it anew with the same coordinates and filters: qerr analyze SPEC -o OLD.json");
  for (const JudgedRequirement& r : old.requirements)
    if (std::ranges::none_of(now.requirements,
                             [&](const JudgedRequirement& other) { return same_limit(r, other); }))
      check.dropped_requirements.push_back(r);
  for (const JudgedRequirement& r : now.requirements)
    if (!find_figure(old, r.figure) &&
        std::ranges::none_of(old.requirements, [&](const JudgedRequirement& other) {
          return other.figure.name() == r.figure.name();
        }))
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
