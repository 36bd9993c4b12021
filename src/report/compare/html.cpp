#include <algorithm>
#include <cctype>
#include <cmath>

#include "qerr/report/comparison.hpp"
#include "qerr/report/write.hpp"
#include "report/compare/parts.hpp"
#include "report/formats.hpp"
#include "report/page/bars.hpp"
#include "report/page/markup.hpp"
#include "report/page/page.hpp"
#include "report/page/prose.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

/// Pictures beyond which a page would be a list.
constexpr std::size_t most_pictures = 24, most_compared_rows = 400;

std::string side_text(const NamedFigures& f) {
  std::string text = page::isolated(f.file);
  for (std::size_t i = 0; i < f.changes.size(); ++i)
    text += (i ? ", " : " with ") + page::isolated(f.changes[i]);
  return text;
}

/// Title block of both sides.
std::string sides(const ReportComparison& c) {
  const auto side = [](const std::string& name, const NamedFigures& f) {
    std::string text = page::escaped_markup(side_text(f));
    for (const std::string& more : {f.robot, f.sample})
      if (!more.empty()) text += "<br/>" + page::name_markup(more);
    return "<dt>" + name + "</dt><dd>" + text + "</dd>";
  };
  return "<div class=\"head\"><dl class=\"about\">" + side("A (before)", c.a) + side("B (after)", c.b) +
         "<dt>Compared by</dt><dd>qerr " + std::string(version()) + "</dd></dl></div>\n";
}

/// Bars start at zero: what is unbounded or negative has none.
bool has_bar(const std::optional<double>& value) { return value && std::isfinite(*value) && *value >= 0; }

std::string pair_of_bars(const FigureChange& f) {
  page::Bars bars{f.figure.name(), "The figure before (A) and after (B).", {}, {"", f.figure.unit}};
  bars.bars.push_back({"A", *f.a, readable(*f.a, f.figure.unit)});
  bars.bars.push_back({"B", *f.b, readable(*f.b, f.figure.unit) + " (" + change_text(f) + ")", {}, 1});
  return figure(bars);
}

std::string figure_pictures(const std::vector<FigureChange>& notable) {
  std::string out;
  std::size_t drawn = 0, possible = 0;
  for (const FigureChange& f : notable) {
    if (!has_bar(f.a) || !has_bar(f.b)) continue;
    if (++possible <= most_pictures) out += pair_of_bars(f), ++drawn;
  }
  if (drawn == 0) return "<p>No figure of both reports has changed in its first three digits.</p>";
  out = "<div class=\"figures\">" + out + "</div>";
  if (drawn < possible)
    out += "<p>The " + std::to_string(drawn) + " largest changes of " + std::to_string(possible) +
           " are drawn; the table has the others.</p>";
  return out;
}

std::string figure_table(const std::vector<FigureChange>& notable) {
  std::vector<std::vector<std::string>> rows;
  for (const FigureChange& f : notable)
    if (rows.size() < most_compared_rows)
      rows.push_back(
          {f.figure.name(), readable(*f.a, f.figure.unit), readable(*f.b, f.figure.unit), change_text(f)});
  if (rows.empty()) return "";
  std::string out = page::table({"figure", "A", "B", "change"}, rows);
  if (rows.size() < notable.size())
    out +=
        "<p>The first " + std::to_string(rows.size()) + " of " + counted(notable.size(), "figure") + ".</p>";
  return out;
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

std::string flip_picture(const ReportComparison& c) {
  page::Bars bars{"Part of the change after which a requirement flips",
                  "The values are taken to change evenly from A to B.",
                  {{"the whole change", 1, percent(1)}}};
  for (const RequirementChange& r : c.requirements)
    if (const auto after = r.flips_after(); after && bars.bars.size() <= most_pictures)
      bars.bars.push_back({r.any().figure.name() + ", " + flip_text(r), *after, percent(*after)});
  return bars.bars.size() == 1 ? "" : figure(bars);
}

std::string requirement_section(const ReportComparison& c) {
  if (c.requirements.empty()) return "<p>Neither report has requirements.</p>";
  std::vector<std::vector<std::string>> rows;
  for (const RequirementChange& r : c.requirements) {
    const auto after = r.flips_after();
    if (rows.size() < most_compared_rows)
      rows.push_back({r.any().figure.name(), judged_text(r.a), judged_text(r.b), flip_text(r),
                      r.b ? percent(margin(*r.b)) : "", after ? percent(*after) : ""});
  }
  return "<p>" + page::escaped_markup(first_flip(c)) + "</p>" + flip_picture(c) +
         page::table({"requirement", "A", "B", "verdict", "margin in B", "flips after"}, rows);
}

/// A bar of each encoder's share before, and one after.
std::string share_section(const ReportComparison& c) {
  page::Bars bars{"Shares of the tip's mean variance",
                  "Of each encoder, before (A) and after (B), the largest differences first.",
                  {}};
  for (const ShareChange& s : c.shares) {
    if (bars.bars.size() >= 2 * most_pictures) break;
    if (has_bar(s.a)) bars.bars.push_back({s.encoder + ", A", *s.a, percent(*s.a)});
    if (has_bar(s.b)) bars.bars.push_back({s.encoder + ", B", *s.b, percent(*s.b), {}, 1});
  }
  return bars.bars.empty() ? "<p>Not in both reports.</p>" : figure(bars);
}

/// Figures of one report only, by quantity.
std::string single_figures(const ReportComparison& c, bool in_a) {
  std::vector<std::string> names;
  for (const FigureChange& f : c.figures)
    if (!f.in_both() && f.a.has_value() == in_a &&
        std::find(names.begin(), names.end(), f.figure.quantity) == names.end())
      names.push_back(f.figure.quantity);
  if (names.empty()) return "";
  std::string out = std::string("<p>Only in ") + (in_a ? "A" : "B") + ": ";
  for (std::size_t i = 0; i < std::min(names.size(), most_compared_rows); ++i)
    out += (i ? ", " : "") + page::name_markup(names[i]);
  return out + (names.size() > most_compared_rows ? ", \u2026" : "") + "</p>";
}

}  // namespace

std::string to_html(const ReportComparison& c, const Style&) {
  const std::vector<FigureChange> notable = notable_figures(c);
  std::string sentence = comparison_sentence(c);
  sentence.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(sentence.front())));
  page::Page page{
      "Comparison of two reports",
      sentence + ".",
      {{"Requirements", requirement_section(c)},
       {"Before and after", figure_pictures(notable)},
       {"Shares of the encoders", share_section(c)},
       {"All changes", figure_table(notable) + single_figures(c, true) + single_figures(c, false)}},
      c.warnings};
  page.about = sides(c);
  return markup(page);
}

}  // namespace qerr
