#include "report/csv_text.hpp"
#include "report/formats.hpp"

namespace qerr {

std::string to_csv(const CheckReport& report, const Style&) {
  std::string out = "quantity,statistic,at_most,value,unit,met\r\n";
  for (std::size_t i = 0; i < report.results.size(); ++i) {
    const Requirement& r = report.analysis.spec.requirements[i];
    out += csv_cell(r.quantity) + ',' + r.statistic + ',' + csv_number(r.at_most) + ',' +
           csv_number(report.results[i].value) + ',' + r.unit + ',' +
           (report.results[i].met ? "true" : "false") + "\r\n";
  }
  return out;
}

}  // namespace qerr
