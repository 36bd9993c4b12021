#include "qerr/report/comparison.hpp"
#include "report/csv_text.hpp"
#include "report/formats.hpp"
#include "report/output_schemas.hpp"

namespace qerr {

/// Of a requirement A and B are whether it is met, and the change is `flipped` or empty.
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

}  // namespace qerr
