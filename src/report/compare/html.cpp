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

/// Beyond these a page would be a list.
constexpr std::size_t most_bars = 48, most_compared_rows = 400;

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
    const std::string hash = f.sha256.empty() ? "" : "SHA-256 " + f.sha256.substr(0, 12);
    for (const std::string& more : {hash, f.robot, f.sample})
      if (!more.empty()) text += "<br/>" + page::name_markup(more);
    return "<dt>" + name + "</dt><dd>" + text + "</dd>";
  };
  return "<div class=\"head\"><dl class=\"about\">" + side("A (before)", c.a) + side("B (after)", c.b) +
         "<dt>Compared by</dt><dd>qerr " + std::string(version()) + "</dd></dl></div>\n";
}

/// Bars start at zero: what is unbounded or negative has none.
bool has_bar(const std::optional<double>& value) { return value && std::isfinite(*value) && *value >= 0; }

/// A cell of a figure whose bar has the colour of its side; the larger one of A and B is whole.
std::string side_cell(const FigureChange& f, bool of_a) {
  const double value = of_a ? *f.a : *f.b, largest = std::max(*f.a, *f.b);
  const std::string text = readable(value, f.figure.unit);
  if (!has_bar(f.a) || !has_bar(f.b) || largest == 0) return "<td>" + page::escaped_markup(text) + "</td>";
  return page::bar_cell(text, value / largest, value, of_a ? 0 : 1);
}

std::string figure_table(const std::vector<FigureChange>& notable) {
  if (notable.empty()) return "<p>No figure of both reports has changed in its first three digits.</p>";
  std::string out =
      "<div class=\"wide\"><table class=\"changes\"><thead><tr><th scope=\"col\">figure</th><th "
      "scope=\"col\">A</th><th scope=\"col\">B</th><th scope=\"col\">change</th></tr></thead><tbody>\n";
  const std::size_t rows = std::min(notable.size(), most_compared_rows);
  for (std::size_t i = 0; i < rows; ++i)
    out += "<tr><td>" + page::name_markup(notable[i].figure.name()) + "</td>" + side_cell(notable[i], true) +
           side_cell(notable[i], false) + "<td>" + page::escaped_markup(change_text(notable[i])) +
           "</td></tr>\n";
  out += "</tbody></table></div>\n";
  if (rows < notable.size())
    out += "<p>The first " + std::to_string(rows) + " of " + counted(notable.size(), "figure") + ".</p>";
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

std::string requirement_section(const ReportComparison& c) {
  if (c.requirements.empty()) return "<p>Neither report has requirements.</p>";
  std::string out = "<p>" + page::escaped_markup(first_flip(c)) +
                    "</p><div class=\"wide\"><table class=\"flips\"><thead><tr>";
  for (const char* head : {"requirement", "A", "B", "verdict", "margin in B", "flips after"})
    out += std::string("<th scope=\"col\">") + head + "</th>";
  out += "</tr></thead><tbody>\n";
  for (std::size_t i = 0; i < std::min(c.requirements.size(), most_compared_rows); ++i) {
    const RequirementChange& r = c.requirements[i];
    const auto after = r.flips_after();
    out += "<tr><td>" + page::name_markup(r.any().figure.name()) + "</td>";
    for (const std::string& text :
         {judged_text(r.a), judged_text(r.b), flip_text(r), r.b ? percent(margin(*r.b)) : std::string()})
      out += "<td>" + page::escaped_markup(text) + "</td>";
    out += (after ? page::bar_cell(percent(*after), *after, *after) : "<td></td>") + "</tr>\n";
  }
  return out + "</tbody></table></div>\n";
}

/// A bar of each encoder's share before, and one after.
std::string share_section(const ReportComparison& c) {
  page::Bars bars{"Shares of the tip's mean variance",
                  "Of each encoder, before (A) and after (B), the largest differences first.",
                  {}};
  for (const ShareChange& s : c.shares) {
    if (bars.bars.size() >= most_bars) break;
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
       {"Shares of the encoders", share_section(c)}},
      c.warnings};
  page.about = sides(c);
  return page;
}

}  // namespace qerr
