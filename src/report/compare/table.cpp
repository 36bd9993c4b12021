#include <algorithm>
#include <cmath>
#include <set>

#include "qerr/report/comparison.hpp"
#include "report/analysis/requirements.hpp"
#include "report/compare/parts.hpp"
#include "report/formats.hpp"
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

std::vector<std::string> names_in_one(const ReportComparison& c, bool in_a, bool quantities) {
  std::vector<std::string> names;
  for (const FigureChange& f : c.figures)
    if (!f.in_both() && f.a.has_value() == in_a)
      add_once(names, quantities ? f.figure.quantity : f.figure.name());
  return names;
}

std::string judged_text(const std::optional<JudgedRequirement>& r) {
  if (!r) return "no such requirement";
  return readable(r->figure.value, r->figure.unit) + ' ' + relation(r->at_least, r->met) + ' ' +
         readable(r->limit, r->figure.unit);
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

namespace {

constexpr std::size_t told_at_most = 20;   // of figures, without --details
constexpr std::size_t named_at_most = 10;  // of figures in one report only, without --details

std::string shown_value(const std::optional<double>& value, const std::string& unit) {
  return value ? readable(*value, unit) : "-";
}

std::string next_line(const ReportComparison& c, const Style& style) {
  const RequirementChange* r = next_to_flip(c);
  if (r == nullptr) return "";
  return wrapped("next to flip: " + shown(r->any().figure.name()) + ", margin " + percent(margin(*r->a)) +
                     " in A, " + percent(margin(*r->b)) + " in B",
                 style.width, "  ");
}

std::string requirements_section(const ReportComparison& c, const Style& style) {
  if (c.requirements.empty()) return "";
  std::string out = heading("Requirements", style);
  std::size_t same = 0;
  for (const RequirementChange& r : c.requirements) {
    const bool plain = r.a && r.b && !r.flipped() && r.b->met;
    if (plain && !c.details) {
      ++same;
      continue;
    }
    std::string title = wrapped(shown(r.any().figure.name()) + ": " + flip_text(r), style.width, "  ");
    title.pop_back();
    if (r.b && !r.b->met)
      title = painted(title, Paint::red, style);
    else if (r.flipped())
      title = painted(title, Paint::green, style);
    out += title + '\n';
    std::string values = "A " + judged_text(r.a) + "; B " + judged_text(r.b);
    if (const auto after = r.flips_after()) values += "; flips after " + percent(*after) + " of the change";
    out += wrapped(values, style.width, "      ");
  }
  if (same > 0) out += "  " + counted(same, "requirement") + " met in both\n";
  return out + next_line(c, style);
}

std::string figures_section(const ReportComparison& c, const Style& style) {
  const std::vector<FigureChange> notable = notable_figures(c);
  if (notable.empty()) return "";
  const std::size_t rows = c.details ? notable.size() : std::min(told_at_most, notable.size());
  TableRows cells{{"figure", "A", "B", "change"}};
  for (std::size_t i = 0; i < rows; ++i) {
    const FigureChange& f = notable[i];
    cells.push_back({shown(f.figure.name()), shown_value(f.a, f.figure.unit), shown_value(f.b, f.figure.unit),
                     change_text(f)});
  }
  std::string out = table_section("Figures, the largest changes first", cells, style);
  if (rows < notable.size()) out += "  and " + std::to_string(notable.size() - rows) + " more: --details\n";
  return out;
}

std::string shares_section(const ReportComparison& c, const Style& style) {
  const auto printed = [](const std::optional<double>& s) { return s ? percent(*s) : "-"; };
  TableRows cells{{"encoder", "A", "B", "points"}};
  for (const ShareChange& s : c.shares)
    if (c.details || printed(s.a) != printed(s.b)) {
      const double points = 100 * (s.b.value_or(0) - s.a.value_or(0));
      cells.push_back(
          {shown(s.encoder), printed(s.a), printed(s.b), (points > 0 ? "+" : "") + fixed_point(points, 1)});
    }
  return table_section("Shares of the tip's variance", cells, style);
}

/// Figures of one report only, by quantity.
std::string only_in(const ReportComparison& c, bool a, const Style& style) {
  const std::vector<std::string> names = names_in_one(c, a, !c.details);
  if (names.empty()) return "";
  std::string out = heading(std::string("Only in ") + (a ? "A" : "B"), style);
  const std::size_t rows = c.details ? names.size() : std::min(named_at_most, names.size());
  for (std::size_t i = 0; i < rows; ++i) out += "  " + shown(names[i]) + '\n';
  if (rows < names.size()) out += "  and " + std::to_string(names.size() - rows) + " more: --details\n";
  return out;
}

/// `B: arm.yaml with encoders.a2.bits=19`.
std::string side_line(const char* side, const NamedFigures& f, const Style& style) {
  const auto name = [](const std::string& text) { return escaped(text, 200); };
  const std::string text = name(f.file) + (f.changes.empty() ? "" : " with " + joined(f.changes, ", ", name));
  return wrapped(text, style.width, "   ", side, LongWords::cut);
}

std::string summary(const ReportComparison& c, const Style& style) {
  const std::string text = comparison_sentence(c);
  std::string line = wrapped(text, style.width);
  line.pop_back();
  const bool bad = text.find("NOT MET") != std::string::npos;
  return (bad ? painted(line, Paint::red, style) : painted(line, Paint::bold, style)) + '\n';
}

}  // namespace

std::string to_table(const ReportComparison& c, const Style& style) {
  return side_line("A: ", c.a, style) + side_line("B: ", c.b, style) + summary(c, style) +
         requirements_section(c, style) + figures_section(c, style) + shares_section(c, style) +
         only_in(c, true, style) + only_in(c, false, style);
}

}  // namespace qerr
