#include <algorithm>
#include <cctype>
#include <cmath>

#include "qerr/report/comparison.hpp"
#include "qerr/report/write.hpp"
#include "report/compare/parts.hpp"
#include "report/formats.hpp"
#include "report/page/markup.hpp"
#include "report/page/page.hpp"
#include "report/text_table.hpp"

namespace qerr {

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

}  // namespace qerr
