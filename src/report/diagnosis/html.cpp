#include <algorithm>
#include <utility>

#include "core/text.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "report/analysis/about.hpp"
#include "report/analysis/requirements.hpp"
#include "report/diagnosis/page/residuals.hpp"
#include "report/diagnosis/parts.hpp"
#include "report/formats.hpp"
#include "report/page/page.hpp"
#include "report/page/plot.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

std::string probability_text(double p) { return p < 1e-15 ? "< 1e-15" : significant(p, 2); }

}  // namespace

std::string curve_figure(const Spec& spec, const std::string& title, const std::string& joint,
                         const ResidualCurve& curve, bool marks) {
  if (curve.at.empty()) return "";
  const std::string unit = curve.unit.starts_with("count") || curve.unit == "1" ? "" : curve.unit;
  page::Plot plot{
      page::isolated_runs(title),
      curve.fit.empty()
          ? "Mean residual in bins of the abscissa."
          : "Mean residual without this cause in bins of the abscissa, and the fitted contribution.",
      {curve.against + (unit.empty() && !curve.unit.empty() ? " [" + curve.unit + "]" : ""), unit, false,
       unit == "s" ? page::time_axis(curve.at.back()).prefix : !unit.starts_with("rad")},
      {"residual", coordinate_unit(spec, joint)},
      {}};
  page::Series residual{curve.fit.empty() ? "residual" : "residual without this", {}, marks, !marks};
  page::Series fit{"fit", {}};
  for (std::size_t i = 0; i < curve.at.size(); ++i) {
    residual.points.emplace_back(curve.at[i], curve.residual[i]);
    if (!curve.fit.empty()) fit.points.emplace_back(curve.at[i], curve.fit[i]);
  }
  plot.series.push_back(residual);
  if (!curve.fit.empty()) plot.series.push_back(fit);
  return figure(plot);
}

bool has_few_curves(const Diagnosis& d) {
  constexpr std::ptrdiff_t few = 6;
  const auto drawn = [](const auto& part) { return !part.curve.at.empty(); };
  return std::count_if(d.causes.begin(), d.causes.end(), drawn) +
             std::count_if(d.unexplained.begin(), d.unexplained.end(), drawn) <=
         few;
}

std::string causes_part(const DiagnosisReport& r) {
  const bool marks = has_few_curves(r.diagnosis);
  std::string out;
  for (const Cause& c : r.diagnosis.causes) {
    std::vector<std::string> facts;
    for (const std::string& fact : {size_words(r, c), loss_words(r, c)})
      if (!fact.empty()) facts.push_back(fact);
    if (const auto remedy = effect_kind(c.effect.type).remedy.text; !remedy.empty())
      facts.push_back("remedy: " + std::string(remedy));
    facts.push_back("probability of such a fit without it: " + probability_text(c.p_value));
    for (const std::string& other : alternatives_to(r.diagnosis, &c)) facts.push_back("or: " + other);
    out += "<div class=\"cause\">" + page::subtitle(label(c)) + page::list(facts) +
           curve_figure(r.spec, "Residual without " + label(c) + ", and its fit", c.effect.joint, c.curve,
                        marks) +
           "</div>\n";
  }
  return page::side_by_side(out) + page::list(alternatives_to(r.diagnosis, nullptr));
}

std::string parameters_part(const DiagnosisReport& r) {
  TableRows rows;
  for (const Cause& c : r.diagnosis.causes)
    for (const ReportedParameter& p : reported_parameters(r.spec, c))
      rows.push_back({label(c), p.figure.name, parameter_size(r.spec, c, p), probability_text(c.p_value)});
  if (rows.empty()) return "";
  return page::table({"cause", "parameter", "value with 95 % interval", "p of the cause"}, rows);
}

std::string remainder_part(const DiagnosisReport& r) {
  std::string out = page::list(remainder_lines(r.diagnosis)), curves;
  const bool marks = has_few_curves(r.diagnosis);
  std::vector<std::string> shapes;
  for (const Unidentified& u : r.diagnosis.unexplained) {
    shapes.push_back(shown(u.joint) + ": " + shape_words(r.spec, u));
    curves += curve_figure(r.spec, "Unidentified: " + shapes.back(), u.joint, u.curve, marks);
  }
  if (!shapes.empty()) out += page::subtitle("Significant, unidentified") + page::list(shapes);
  return out + page::side_by_side(curves);
}

std::string next_part(const DiagnosisReport& r) {
  std::vector<std::string> items = advice_lines(r.diagnosis);
  std::vector<std::pair<std::string, std::string>> remedies;  // and the joints
  for (const DataFinding& f : r.diagnosis.data) {
    if (f.remedy.empty()) continue;
    const auto same = std::find_if(remedies.begin(), remedies.end(),
                                   [&](const auto& other) { return other.first == f.remedy; });
    const std::string joint = f.joint.empty() ? "the whole record" : shown(f.joint);
    if (same == remedies.end())
      remedies.emplace_back(f.remedy, joint);
    else if ((", " + same->second + ",").find(", " + joint + ",") == std::string::npos)
      same->second += ", " + joint;
  }
  for (const auto& [remedy, joints] : remedies) items.push_back(joints + ": " + remedy);
  const std::vector<std::string> hidden = hidden_lines(r.diagnosis);
  if (hidden.empty()) return page::list(items);
  return page::list(items) + page::subtitle("What this motion hides") + page::list(hidden) +
         page::paragraph("qerr diagnose SPEC --plan proposes a motion that shows more.");
}

std::string record_part(const DiagnosisReport& r) {
  std::vector<std::string> items;
  for (const DataFinding& f : r.diagnosis.data) items.push_back(place_of(f) + ": " + f.what);
  return page::list(items);
}

std::string visible_part(const DiagnosisReport& r) {
  TableRows sizes = visible_sizes(r.diagnosis);
  if (sizes.empty()) return "";
  return page::paragraph("Each effect from this size on, had it been there:") + page::table(std::move(sizes));
}

std::string gain_part(const DiagnosisReport& r) {
  const Diagnosis& d = r.diagnosis;
  if (d.verdict == Verdict::cannot_judge && d.causes.empty()) return "";
  std::vector<std::string> remarks = prediction_lines(d.gain);
  if (d.gain.held_out) remarks.insert(remarks.begin(), "after: on held-out blocks of the log");
  return page::table(gain_rows(d)) + page::list(remarks);
}

namespace {

/// Lines of a terminal's table as clauses of a sentence.
std::string in_one_line(const std::string& lines) {
  std::string out;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (lines[i] != '\n') {
      out += lines[i];
      continue;
    }
    out += "; ";
    i = std::min(lines.find_first_not_of(' ', i + 1), lines.size()) - 1;
  }
  return out;
}

}  // namespace

page::Page page_of(const DiagnosisReport& r) {
  const Diagnosis& d = r.diagnosis;
  page::Page page{"Diagnosis of " + r.spec.robot_name,
                  page::isolated_runs(verdict_title(d) + ": " + verdict_words(r) + "."),
                  {},
                  r.warnings};
  describe(page, r.spec, verdicts_beside(r.spec));
  const auto add = [&](const std::string& heading, const std::string& body) {
    if (!body.empty()) page.sections.push_back({heading, body});
  };
  add("Causes", causes_part(r));
  add("Sizes of the causes", parameters_part(r));
  add("What to record next", next_part(r));
  const auto before_and_after = static_cast<std::ptrdiff_t>(page.sections.size());
  add("What remains", remainder_part(r));
  add("What the record would have shown", visible_part(r));
  add("Gain", gain_part(r));
  add("The record", page::paragraph(in_one_line(record_words(r.log)) + "."));
  add("Faults of the record itself", record_part(r));
  if (std::string residuals = residuals_part(r, page::bytes_left(page)); !residuals.empty())
    page.sections.insert(page.sections.begin() + before_and_after,
                         {"Before and after", std::move(residuals)});
  return page;
}

}  // namespace qerr
