#include "qerr/report/comparison.hpp"
#include "report/csv_text.hpp"
#include "report/formats.hpp"

namespace qerr {

/// Of a requirement A and B are whether it is met, and the change is `flipped` or empty.
std::string to_csv(const ReportComparison& c, const Style&) {
  std::string out = "section,name,statistic,unit,a,b,change\r\n";
  const auto met = [](const std::optional<JudgedRequirement>& r) {
    return std::string(!r ? "" : r->met ? "true" : "false");
  };
  for (const RequirementChange& r : c.requirements) {
    const NamedFigure& f = r.any().figure;
    out += "requirement," + csv_cell(f.quantity) + ',' + f.statistic + ',' + f.unit + ',' + met(r.a) + ',' +
           met(r.b) + (r.flipped() ? ",flipped" : ",") + "\r\n";
  }
  for (const FigureChange& f : c.figures)
    out += "figure," + csv_cell(f.figure.quantity) + ',' + f.figure.statistic + ',' + f.figure.unit + ',' +
           csv_number(f.a) + ',' + csv_number(f.b) + ',' + csv_number(f.relative) + "\r\n";
  for (const ShareChange& s : c.shares)
    out += "share," + csv_cell(s.encoder) + ",,1," + csv_number(s.a) + ',' + csv_number(s.b) + ',' +
           (s.a && s.b ? csv_number(*s.b - *s.a) : "") + "\r\n";
  return out;
}

}  // namespace qerr
