#include "report/analysis/json_header.hpp"
#include "report/formats.hpp"

namespace qerr {

namespace {

Json of_spec(const SpecCheck& check) {
  Json list = Json::array();
  for (std::size_t i = 0; i < check.results.size(); ++i) {
    const Requirement& r = check.analysis.spec.requirements[i];
    Json row = {{"quantity", r.quantity}};
    if (!r.figure) row["statistic"] = r.statistic;
    row[std::string(r.relation())] = r.limit;
    row["value"] = check.results[i].value;
    row["unit"] = r.unit;
    row["met"] = check.results[i].met;
    list.push_back(row);
  }
  Json j = analysis_header(check.analysis, "check");
  j["requirements"] = list;
  j["met"] = check.all_met();
  j["warnings"] = check.analysis.warnings;
  return j;
}

}  // namespace

/// Of one spec its report; of several a list of such reports.
std::string to_json(const CheckReport& report, const Style&) {
  if (report.specs.size() == 1) return of_spec(report.specs.front()).document();
  Json list = Json::array();
  for (const SpecCheck& check : report.specs) list.push_back(of_spec(check));
  Json j = {{"qerr", version()}, {"command", "check"}};
  j["reports"] = list;
  j["met"] = report.all_met();
  return j.document();
}

}  // namespace qerr
