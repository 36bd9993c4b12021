#include "report/formats.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

#include "report/analysis/figures.hpp"
#include "report/compare/parts.hpp"
#include "report/text_table.hpp"

namespace qerr {

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
  return std::ranges::any_of(all, [&](const FigureChange& o) {
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

/// The figures of both reports that are worth a reader's time: those that read differently, and without
/// `details` only the maximum of a quantity in place of its other statistics.
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

/// Figures that only A, or only B, has: their names, or their quantities.
std::vector<std::string> names_in_one(const ReportComparison& c, bool in_a, bool quantities) {
  std::vector<std::string> names;
  for (const FigureChange& f : c.figures)
    if (!f.in_both() && f.a.has_value() == in_a)
      add_once(names, quantities ? f.figure.quantity : f.figure.name());
  return names;
}

/// `1.2 mm <= 1.5 mm`; `no such requirement`.
std::string judged_text(const std::optional<JudgedRequirement>& r) {
  if (!r) return "no such requirement";
  return readable(r->figure.value, r->figure.unit) + ' ' + relation(r->at_least, r->met) + ' ' +
         readable(r->limit, r->figure.unit);
}

/// `NOT MET any more`: which way a verdict flipped.
std::string flip_text(const RequirementChange& r) {
  if (!r.a || !r.b) return r.a ? "only in A" : r.b->met ? "only in B, met" : "only in B, NOT MET";
  if (r.flipped()) return r.b->met ? "NOW MET" : "NOT MET any more";
  return r.b->met ? "met in both" : "NOT MET in both";
}

/// The requirement that is met in both and has the smallest margin in B; null: none.
const RequirementChange* next_to_flip(const ReportComparison& c) {
  for (const RequirementChange& r : c.requirements)
    if (r.a && r.b && !r.flipped() && r.b->met && !std::isnan(margin(*r.b))) return &r;
  return nullptr;
}

/// What has flipped, and how many figures grew and shrank.
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

namespace {

constexpr std::size_t most_compared_rows = 400;

std::string side_text(const NamedFigures& f) {
  return page::isolated(f.file) +
         (f.changes.empty() ? "" : " with " + joined(f.changes, ", ", page::isolated));
}

/// Title block of both sides.
std::string sides(const ReportComparison& c) {
  const auto side = [](const std::string& name, const NamedFigures& f) {
    std::string text = page::escaped_markup(side_text(f));
    const std::string hash = f.sha256.empty() ? "" : "SHA-256 " + f.sha256.substr(0, 12);
    for (const std::string& more : {hash, f.robot, f.sample})
      if (!more.empty()) text += "<br/>" + page::name_markup(more);
    return std::pair(name, text);
  };
  return page::title_list({side("A (before)", c.a),
                           side("B (after)", c.b),
                           {"Compared by", "qerr " + std::string(version())}}) +
         "</div>\n";
}

/// Bars start at zero: what is unbounded or negative has none.
bool has_bar(const std::optional<double>& value) { return value && std::isfinite(*value) && *value >= 0; }

/// A cell of a figure whose bar has the colour of its side; the larger one of A and B is whole.
std::string side_cell(const FigureChange& f, bool of_a) {
  const double value = of_a ? *f.a : *f.b, largest = std::max(*f.a, *f.b);
  const std::string text = readable(value, f.figure.unit);
  if (!has_bar(f.a) || !has_bar(f.b) || largest == 0) return page::cell(text);
  return page::bar_cell(text, value / largest, value, of_a ? 0 : 1);
}

std::string figure_table(const std::vector<FigureChange>& notable) {
  if (notable.empty()) return "<p>No figure of both reports has changed in its first three digits.</p>";
  std::vector<std::string> rows;
  for (const FigureChange& f : notable)
    if (rows.size() < most_compared_rows)
      rows.push_back(page::cell(f.figure.name()) + side_cell(f, true) + side_cell(f, false) +
                     page::cell(change_text(f)));
  return page::table_of("changes", {"figure", "A", "B", "change"}, rows) +
         (rows.size() < notable.size() ? "<p>The first " + std::to_string(rows.size()) + " of " +
                                             counted(notable.size(), "figure") + ".</p>"
                                       : "");
}

/// Which requirement flips first on the way from A to B, or is next to.
std::string first_flip(const ReportComparison& c) {
  if (!c.requirements.empty() && c.requirements.front().flipped()) {
    const RequirementChange& r = c.requirements.front();
    return "First to flip on the way from A to B, if the figures change evenly: " +
           page::isolated(r.any().figure.name()) + ", after " + percent(*r.flips_after()) +
           " of the change (" + flip_text(r) + ").";
  }
  if (const RequirementChange* r = next_to_flip(c))
    return "No requirement flips. The next to flip is " + page::isolated(r->any().figure.name()) +
           ": its margin is " + percent(margin(*r->a)) + " in A and " + percent(margin(*r->b)) + " in B.";
  return "No requirement flips.";
}

std::string requirement_section(const ReportComparison& c) {
  if (c.requirements.empty()) return "<p>Neither report has requirements.</p>";
  std::vector<std::string> rows;
  for (const RequirementChange& r : c.requirements) {
    if (rows.size() == most_compared_rows) break;
    const auto after = r.flips_after();
    rows.push_back(page::cell(r.any().figure.name()) + page::cell(judged_text(r.a)) +
                   page::cell(judged_text(r.b)) + page::cell(flip_text(r)) +
                   page::cell(r.b ? percent(margin(*r.b)) : "") +
                   (after ? page::bar_cell(percent(*after), *after, *after) : page::cell("")));
  }
  return page::paragraph(first_flip(c)) +
         page::table_of("flips", {"requirement", "A", "B", "verdict", "margin in B", "flips after"}, rows);
}

/// The encoders' shares before and after, each over the largest one.
std::string share_section(const ReportComparison& c) {
  double largest = 0;
  for (const ShareChange& s : c.shares) largest = std::max({largest, s.a.value_or(0), s.b.value_or(0)});
  const auto share = [&](const std::optional<double>& value, int colour) {
    return value && largest > 0 ? page::bar_cell(percent(*value), *value / largest, *value, colour)
                                : page::cell("-");
  };
  std::vector<std::string> rows;
  for (const ShareChange& s : c.shares) rows.push_back(page::cell(s.encoder) + share(s.a, 0) + share(s.b, 1));
  return rows.empty() ? "<p>Not in both reports.</p>" : page::table_of("shares", {"encoder", "A", "B"}, rows);
}

/// Figures of one report only, by quantity.
std::string single_figures(const ReportComparison& c, bool in_a) {
  std::vector<std::string> names = names_in_one(c, in_a, true);
  if (names.empty()) return "";
  const bool all = names.size() <= most_compared_rows;
  if (!all) names.resize(most_compared_rows);
  return std::string("<p>Only in ") + (in_a ? "A" : "B") + ": " + joined(names, ", ", page::name_markup) +
         (all ? "" : ", \u2026") + "</p>";
}

/// Names of those that flip; "" of none.
std::string flipped_names(const ReportComparison& c) {
  constexpr std::size_t most = 4;
  std::string names;
  std::size_t count = 0;
  for (const RequirementChange& r : c.requirements)
    if (r.flipped() && ++count <= most)
      names += (names.empty() ? " Flipped: " : "; ") + page::isolated(r.any().figure.name()) + ", " +
               judged_text(r.b);
  return names.empty() ? ""
                       : names + (count > most ? " and " + std::to_string(count - most) + " more." : ".");
}

}  // namespace

page::Page page_of(const ReportComparison& c) {
  const std::vector<FigureChange> notable = notable_figures(c);
  std::string sentence = comparison_sentence(c);
  sentence.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(sentence.front())));
  page::Page page{
      "Comparison of two reports",
      sentence + "." + flipped_names(c),
      {{"Requirements", requirement_section(c)},
       {"All changes", figure_table(notable) + single_figures(c, true) + single_figures(c, false)},
       {"Shares of the encoders in the tip's mean variance", share_section(c)}},
      c.warnings};
  page.about = sides(c);
  return page;
}

/// The row of a requirement: A and B are whether it is met, and the change is `flipped` or empty.
std::string to_csv(const ReportComparison& c, const Style&) {
  std::string out = "section,name,statistic,unit,a,b,change\r\n";
  for (const RequirementChange& r : c.requirements)
    out += "requirement," + csv_cells(json_of(r), {"quantity", "statistic", "unit", "a.met", "b.met"}) +
           (r.flipped() ? ",flipped" : ",") + "\r\n";
  for (const FigureChange& f : c.figures)
    out += "figure," + csv_cells(json_of(f), {"figure", "statistic", "unit", "a", "b", "change"}) + "\r\n";
  for (const ShareChange& s : c.shares) {
    const Json share = json_of(s);
    out +=
        "share," + csv_cells(share, {"encoder"}) + ",,1," + csv_cells(share, {"a", "b", "change"}) + "\r\n";
  }
  return out;
}

RowsOf<NamedFigures> rows(Of<NamedFigures>) {
  return {{"file", &NamedFigures::file},
          {"command", &NamedFigures::command, one_of({"analyze", "check", "filter", "spec"}),
           "that wrote the report; spec: its figures are those of now"}};
}

RowsOf<JudgedRequirement> rows(Of<JudgedRequirement>) {
  return {{"at_most", [](auto& r) { return only_if(!r.at_least, r.limit); }, optional},
          {"at_least", [](auto& r) { return only_if(r.at_least, r.limit); }, optional},
          {"value", [](auto& r) { return r.figure.value; }, "null: unbounded", nullable},
          {"met", &JudgedRequirement::met},
          {"margin", [](auto& r) { return margin(r); }, "distance from the limit over the limit", nullable}};
}

RowsOf<FigureChange> rows(Of<FigureChange>) {
  return {{"figure", [](auto& f) { return f.figure.quantity; }, "the name that requirements use"},
          {"statistic", [](auto& f) { return f.figure.statistic; }, "empty: a figure of a filter"},
          {"unit", [](auto& f) { return f.figure.unit; }},
          {"a", &FigureChange::a, "null: unbounded, or only B has it"},
          {"b", &FigureChange::b, "null: unbounded, or only A has it"},
          {"change", &FigureChange::relative,
           "(b - a)/|a|; null: from zero, to unbounded, or one report only", nullable},
          {"only", [](auto& f) { return f.in_both() ? ""
                                        : f.a       ? "a"
                                                    : "b"; }, one_of({"a", "b"}),
           "the report that has the figure, if one has it", optional}};
}

RowsOf<ShareChange> rows(Of<ShareChange>) {
  return {
      {"encoder", &ShareChange::encoder},
      {"a", &ShareChange::a},
      {"b", &ShareChange::b},
      {"change", [](auto& s) { return s.a && s.b ? std::optional(*s.b - *s.a) : std::nullopt; }, "b - a"}};
}

RowsOf<RequirementChange> rows(Of<RequirementChange>) {
  return {{"quantity", [](auto& r) { return r.any().figure.quantity; }},
          {"statistic", [](auto& r) { return r.any().figure.statistic; }, "empty: a figure of a filter"},
          {"unit", [](auto& r) { return r.any().figure.unit; }},
          {"a", &RequirementChange::a, "null: only B has it"},
          {"b", &RequirementChange::b, "null: only A has it"},
          {"flipped", &RequirementChange::flipped},
          {"flips_after", &RequirementChange::flips_after, "part of the way from A to B"}};
}

RowsOf<ReportComparison> rows(Of<ReportComparison>) {
  return header<ReportComparison>("compare").with(
      {{"a", &ReportComparison::a},
       {"b", &ReportComparison::b},
       {"figures", &ReportComparison::figures, "the largest changes first"},
       {"shares", &ReportComparison::shares, "of each encoder in the variance of the tip"},
       {"requirements", &ReportComparison::requirements,
        "flipped ones first, in their order; then the smallest margins in B"},
       {"warnings", &ReportComparison::warnings}});
}

}  // namespace qerr
