#include <algorithm>
#include <cmath>
#include <set>

#include "qerr/report/comparison.hpp"
#include "report/compare/parts.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

bool changed_in_print(const FigureChange& c) {
  return c.in_both() && c.relative != 0 && readable(*c.a, c.figure.unit) != readable(*c.b, c.figure.unit);
}

/// A rigorous bound that is printed as the linear one is.
bool repeats_another(const FigureChange& f, const std::vector<FigureChange>& all) {
  constexpr std::string_view suffix = "_rigorous";
  if (!f.figure.quantity.ends_with(suffix)) return false;
  const std::string linear = f.figure.quantity.substr(0, f.figure.quantity.size() - suffix.size());
  const auto same = [&](double x, double y) {
    return readable(x, f.figure.unit) == readable(y, f.figure.unit);
  };
  return std::any_of(all.begin(), all.end(), [&](const FigureChange& o) {
    return o.figure.quantity == linear && o.figure.statistic == f.figure.statistic && o.in_both() &&
           same(*o.a, *f.a) && same(*o.b, *f.b);
  });
}

std::string flips_sentence(const ReportComparison& c) {
  std::size_t broken = 0, mended = 0;
  for (const RequirementChange& r : c.requirements)
    if (r.flipped()) ++(r.b->met ? mended : broken);
  if (c.requirements.empty()) return "";
  if (broken + mended == 0) return "no requirement flipped; ";
  std::string text;
  if (broken > 0) text += counted(broken, "requirement") + " NOT MET any more; ";
  if (mended > 0) text += counted(mended, "requirement") + " now met; ";
  return text;
}

}  // namespace

std::vector<FigureChange> notable_figures(const ReportComparison& c) {
  std::vector<FigureChange> notable;
  std::set<std::string> spoken_for;
  for (const FigureChange& f : c.figures)
    if (is_main(f.figure) && changed_in_print(f)) spoken_for.insert(f.figure.quantity);
  for (const FigureChange& f : c.figures) {
    if (!f.in_both()) continue;
    const bool wanted = is_main(f.figure) || !spoken_for.contains(f.figure.quantity);
    if (c.details || (wanted && changed_in_print(f) && !repeats_another(f, c.figures))) notable.push_back(f);
  }
  return notable;
}

std::string judged_text(const std::optional<JudgedRequirement>& r) {
  if (!r) return "no such requirement";
  const char* const relation = r->at_least ? (r->met ? " >= " : " < ") : (r->met ? " <= " : " > ");
  return readable(r->figure.value, r->figure.unit) + relation + readable(r->limit, r->figure.unit);
}

std::string flip_text(const RequirementChange& r) {
  if (!r.a || !r.b) return r.a ? "only in A" : r.b->met ? "only in B, met" : "only in B, NOT MET";
  if (r.flipped()) return r.b->met ? "NOW MET" : "NOT MET any more";
  return r.b->met ? "met in both" : "NOT MET in both";
}

const RequirementChange* next_to_flip(const ReportComparison& c) {
  for (const RequirementChange& r : c.requirements)
    if (r.a && r.b && !r.flipped() && r.b->met && !std::isnan(margin(*r.b))) return &r;
  return nullptr;
}

std::string comparison_sentence(const ReportComparison& c) {
  std::size_t both = 0, larger = 0, smaller = 0;
  for (const FigureChange& f : c.figures) {
    both += f.in_both();
    larger += f.relative > 0;
    smaller += f.relative < 0;
  }
  std::string text = flips_sentence(c);
  if (both == 0)
    text += "the reports have no figure in common";
  else if (larger + smaller == 0)
    text += counted(both, "figure") + " in both, all unchanged";
  else
    text += counted(both, "figure") + " in both: " + std::to_string(larger) + " larger, " +
            std::to_string(smaller) + " smaller, " + std::to_string(both - larger - smaller) +
            " unchanged; the largest change is " + change_text(c.figures.front());
  return text;
}

std::string change_text(const FigureChange& c) {
  if (!c.in_both()) return "";
  if (c.relative == 0) return "unchanged";
  if (std::isinf(*c.a)) return "now bounded";
  if (std::isinf(*c.b)) return "now unbounded";
  if (std::isinf(c.relative)) return "from zero";
  if (c.relative > 10 && *c.a > 0)
    return "x " + (c.relative > 998 ? significant(1 + c.relative, 3) : fixed_point(1 + c.relative, 1));
  const std::string size = std::abs(c.relative) < 1e-5 ? significant(100 * std::abs(c.relative), 1) + " %"
                                                       : percent(std::abs(c.relative));
  return (c.relative > 0 ? "+" : "-") + size;
}

}  // namespace qerr
