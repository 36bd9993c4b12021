#include "report/analysis/json_header.hpp"
#include "report/formats.hpp"

namespace qerr {

std::string to_json(const CheckReport& report, const Style&) {
  Json list = Json::array();
  for (std::size_t i = 0; i < report.results.size(); ++i) {
    const Requirement& r = report.analysis.spec.requirements[i];
    list.push_back({{"quantity", r.quantity},
                    {"statistic", r.statistic},
                    {"at_most", r.at_most},
                    {"value", report.results[i].value},
                    {"unit", r.unit},
                    {"met", report.results[i].met}});
  }
  Json j = analysis_header(report.analysis, "check");
  j["requirements"] = list;
  j["met"] = report.all_met();
  j["warnings"] = report.analysis.warnings;
  return j.document();
}

}  // namespace qerr
