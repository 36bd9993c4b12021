#include "qerr/report/comparison.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "core/text.hpp"
#include "qerr/core/error.hpp"
#include "report/analysis/requirements.hpp"
#include "report/compare/parts.hpp"

namespace qerr {

double relative_change(double a, double b) {
  // Sums over configurations differ by some 1e-12 between processors: that is no change of a design.
  constexpr double same = 1e-9;
  if (a == b) return 0;
  if (std::isinf(a)) return -1;
  if (a == 0 || std::isinf(b)) return std::copysign(std::numeric_limits<double>::infinity(), b);
  const double change = (b - a) / std::abs(a);
  return std::abs(change) <= same ? 0 : change;
}

namespace {

/// Reports of analyze and of check have the same figures, those of filter others; a spec has all.
bool comparable(const NamedFigures& a, const NamedFigures& b) {
  const auto all = [](const NamedFigures& f) { return f.command == "spec"; };
  return all(a) || all(b) || (a.command == "filter") == (b.command == "filter");
}

void require_comparable(const NamedFigures& a, const NamedFigures& b) {
  if (!comparable(a, b))
    throw Error(Fault{{b.file},
                      "command",
                      "both reports must be of one command",
                      quoted(b.command) + ", and " + quoted(a.command) + " in " + a.file,
                      "compare the specs, or reports of one command"});
}

void require_one_unit(const NamedFigure& a, const NamedFigure& b, const NamedFigures& in_a,
                      const NamedFigures& in_b) {
  if (a.unit == b.unit) return;
  throw Error(Fault{{in_b.file},
                    b.quantity,
                    "a figure must have one unit",
                    quoted(b.unit) + ", and " + quoted(a.unit) + " in " + in_a.file,
                    "do both estimate the same derivative? Give different filters different names"});
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

}  // namespace

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
    seen[static_cast<std::size_t>(other - b.figures.data())] = true;
  }
  for (std::size_t i = 0; i < seen.size(); ++i)
    if (!seen[i]) changes.push_back({b.figures[i], {}, b.figures[i].value, missing});
  // Figures that are multiples of each other change alike but for rounding, and keep their order.
  const auto size = [](const FigureChange& c) {
    return c.in_both() ? rounded_to(std::abs(c.relative), 9) : -1;
  };
  std::stable_sort(changes.begin(), changes.end(),
                   [&](const FigureChange& x, const FigureChange& y) { return size(x) > size(y); });
  return changes;
}

namespace {

std::vector<ShareChange> share_changes(const NamedFigures& a, const NamedFigures& b) {
  std::vector<ShareChange> changes;
  for (const EncoderShare& s : a.shares) changes.push_back({s.encoder, s.share, {}});
  for (const EncoderShare& s : b.shares) {
    const auto known = std::find_if(changes.begin(), changes.end(),
                                    [&](const ShareChange& c) { return c.encoder == s.encoder; });
    if (known == changes.end())
      changes.push_back({s.encoder, {}, s.share});
    else
      known->b = s.share;
  }
  const auto size = [](const ShareChange& c) { return std::abs(c.b.value_or(0) - c.a.value_or(0)); };
  std::stable_sort(changes.begin(), changes.end(),
                   [&](const ShareChange& x, const ShareChange& y) { return size(x) > size(y); });
  return changes;
}

/// Requirements are the same if they limit the same figure from the same side; repeated ones in their order.
std::vector<RequirementChange> requirement_changes(const NamedFigures& a, const NamedFigures& b) {
  std::vector<RequirementChange> changes;
  for (const JudgedRequirement& r : a.requirements) changes.push_back({r, {}});
  for (const JudgedRequirement& r : b.requirements) {
    const auto known = std::find_if(changes.begin(), changes.end(),
                                    [&](const RequirementChange& c) { return !c.b && same_limit(*c.a, r); });
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
  std::stable_sort(
      changes.begin(), changes.end(),
      [&](const RequirementChange& x, const RequirementChange& y) { return order(x) < order(y); });
  return changes;
}

}  // namespace

double margin(const JudgedRequirement& r) { return margin(r.figure.value, r.limit, r.at_least); }

std::optional<double> RequirementChange::flips_after() const {
  if (!flipped()) return std::nullopt;
  // The limit is B's: where both differ, the requirement that A's figure is compared with changes at once.
  const double from = a->figure.value, to = b->figure.value, limit = b->limit;
  if (!std::isfinite(from)) return 1;  // of what was unbounded, only B is below the limit
  if (!std::isfinite(to) || from == to) return 0;
  return std::clamp((limit - from) / (to - from), 0.0, 1.0);
}

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

const NamedFigure* find_figure(const NamedFigures& in, const NamedFigure& like) {
  const auto found = std::find_if(in.figures.begin(), in.figures.end(), [&](const NamedFigure& f) {
    return f.quantity == like.quantity && f.statistic == like.statistic;
  });
  return found == in.figures.end() ? nullptr : &*found;
}

bool same_limit(const JudgedRequirement& a, const JudgedRequirement& b) {
  return a.figure.quantity == b.figure.quantity && a.figure.statistic == b.figure.statistic &&
         a.at_least == b.at_least;
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

}  // namespace qerr
