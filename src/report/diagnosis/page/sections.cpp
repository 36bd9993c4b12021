#include "report/diagnosis/sections.hpp"

#include "core/text.hpp"
#include "report/diagnosis/page/pictures.hpp"
#include "report/page/page.hpp"
#include "report/page/prose.hpp"
#include "report/text_table.hpp"

namespace qerr {

std::string remainder_part(const DiagnosisReport& r) {
  std::string out = page::list(remainder_lines(r.diagnosis)), curves;
  const bool marks = has_few_curves(r.diagnosis);
  std::vector<std::string> shapes;
  for (const Unidentified& u : r.diagnosis.unexplained) {
    shapes.push_back(shown(u.joint) + ": " + shape_words(r.spec, u));
    curves += curve_figure(r.spec, "Unidentified: " + shapes.back(), u.joint, u.curve, marks);
  }
  if (!shapes.empty()) out += page::subtitle("Significant, unidentified") + page::list(shapes);
  out += page::side_by_side(curves);
  const std::vector<std::string> advice = advice_lines(r.diagnosis);
  return advice.empty() ? out : out + page::subtitle("What to do next") + page::list(advice);
}

std::string record_part(const DiagnosisReport& r) {
  std::vector<std::string> items;
  for (const DataFinding& f : r.diagnosis.data)
    items.push_back(place_of(f) + ": " + f.what + (f.remedy.empty() ? "" : ". Remedy: " + f.remedy));
  return page::list(items);
}

std::string visible_part(const DiagnosisReport& r) {
  std::vector<std::vector<std::string>> sizes = visible_sizes(r.diagnosis);
  std::string out;
  if (!sizes.empty()) {
    const std::vector<std::string> header = sizes.front();
    sizes.erase(sizes.begin());
    out = page::paragraph("Each effect from this size on, had it been there:") +
          page::isolated_table(header, sizes);
  }
  const std::vector<std::string> hidden = hidden_lines(r.diagnosis);
  if (hidden.empty()) return out;
  return out + page::subtitle("What this motion hides") + page::list(hidden) +
         page::paragraph("qerr diagnose SPEC --plan proposes a motion that shows more.");
}

std::string gain_part(const DiagnosisReport& r) {
  const Diagnosis& d = r.diagnosis;
  if (d.verdict == Verdict::cannot_judge && d.causes.empty()) return "";
  std::vector<std::vector<std::string>> rows = gain_rows(d);
  const std::vector<std::string> header = rows.front();
  rows.erase(rows.begin());
  std::vector<std::string> remarks = prediction_lines(d.gain);
  if (d.gain.held_out) remarks.insert(remarks.begin(), "after: on held-out blocks of the log");
  return page::isolated_table(header, rows) + page::list(remarks);
}

}  // namespace qerr
