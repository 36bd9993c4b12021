#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "qerr/report/comparison.hpp"
#include "report/compare/parts.hpp"
#include "report/fitted_table.hpp"
#include "report/formats.hpp"
#include "report/text_table.hpp"
#include "report/wrapped_text.hpp"

namespace qerr {

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
  std::vector<std::vector<std::string>> cells{{"figure", "A", "B", "change"}};
  for (std::size_t i = 0; i < rows; ++i) {
    const FigureChange& f = notable[i];
    cells.push_back({shown(f.figure.name()), shown_value(f.a, f.figure.unit), shown_value(f.b, f.figure.unit),
                     change_text(f)});
  }
  std::string out = heading("Figures, the largest changes first", style) + fitted_table(cells, style.width);
  if (rows < notable.size()) out += "  and " + std::to_string(notable.size() - rows) + " more: --details\n";
  return out;
}

std::string shares_section(const ReportComparison& c, const Style& style) {
  const auto printed = [](const std::optional<double>& s) { return s ? percent(*s) : "-"; };
  std::vector<std::vector<std::string>> cells{{"encoder", "A", "B", "points"}};
  for (const ShareChange& s : c.shares)
    if (c.details || printed(s.a) != printed(s.b)) {
      const double points = 100 * (s.b.value_or(0) - s.a.value_or(0));
      cells.push_back(
          {shown(s.encoder), printed(s.a), printed(s.b), (points > 0 ? "+" : "") + fixed_point(points, 1)});
    }
  if (cells.size() == 1) return "";
  return heading("Shares of the tip's variance", style) + fitted_table(cells, style.width);
}

/// Figures of one report only, by quantity.
std::string only_in(const ReportComparison& c, bool a, const Style& style) {
  std::vector<std::string> names;
  for (const FigureChange& f : c.figures) {
    if (f.in_both() || f.a.has_value() != a) continue;
    const std::string name = shown(c.details ? f.figure.name() : f.figure.quantity);
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  if (names.empty()) return "";
  std::string out = heading(std::string("Only in ") + (a ? "A" : "B"), style);
  const std::size_t rows = c.details ? names.size() : std::min(named_at_most, names.size());
  for (std::size_t i = 0; i < rows; ++i) out += "  " + names[i] + '\n';
  if (rows < names.size()) out += "  and " + std::to_string(names.size() - rows) + " more: --details\n";
  return out;
}

/// `B: arm.yaml with encoders.a2.bits=19`.
std::string side_line(const char* side, const NamedFigures& f, const Style& style) {
  std::string text = escaped(f.file, 200);
  for (std::size_t i = 0; i < f.changes.size(); ++i)
    text += (i ? ", " : " with ") + escaped(f.changes[i], 200);
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
