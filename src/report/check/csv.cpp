#include "report/csv_text.hpp"
#include "report/formats.hpp"

namespace qerr {

std::string to_csv(const CheckReport& report, const Style&) {
  std::string out = "quantity,statistic,at_most,value,unit,met,at_least,spec,baseline\r\n";
  for (const SpecCheck& check : report.specs)
    for (std::size_t i = 0; i < check.results.size(); ++i) {
      const Requirement& r = check.analysis.spec.requirements[i];
      const auto limit = [&](bool wanted) { return wanted ? csv_number(r.limit) : std::string(); };
      out += csv_cell(r.quantity) + ',' + r.statistic + ',' + limit(!r.at_least) + ',' +
             csv_number(check.results[i].value) + ',' + r.unit + ',' +
             (check.results[i].met ? "true" : "false") + ',' + limit(r.at_least) + ',' +
             csv_cell(check.analysis.spec.file) + ",\r\n";
    }
  for (const SpecCheck& check : report.specs)
    if (check.baseline)
      for (const FigureChange& c : check.baseline->regressions)
        out += csv_cell(c.figure.quantity) + ',' + c.figure.statistic + ",," + csv_number(c.b) + ',' +
               c.figure.unit + ",false,," + csv_cell(check.analysis.spec.file) + ',' + csv_number(c.a) +
               "\r\n";
  return out;
}

}  // namespace qerr
