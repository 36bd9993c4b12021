#include "report/analysis/json_header.hpp"
#include "report/check/parts.hpp"
#include "report/formats.hpp"

namespace qerr {

namespace {

void add_baseline(const BaselineCheck& b, Json& to) {
  Json missing = Json::array(), added = Json::array(), dropped = Json::array(), regressions = Json::array();
  for (const NamedFigure& f : b.missing) missing.push_back(f.name());
  for (const NamedFigure& f : b.not_in_baseline) added.push_back(f.name());
  for (const JudgedRequirement& r : b.dropped_requirements) dropped.push_back(r.figure.name());
  for (const FigureChange& c : b.regressions)
    regressions.push_back({{"quantity", c.figure.quantity},
                           {"statistic", c.figure.statistic},
                           {"unit", c.figure.unit},
                           {"baseline", c.a},
                           {"value", c.b},
                           {"change", c.relative}});
  to["baseline"] = {{"file", b.file}, {"tolerance", b.tolerance}, {"compared", b.compared}};
  to["baseline"]["missing"] = missing;
  to["baseline"]["dropped_requirements"] = dropped;
  to["baseline"]["not_in_baseline"] = added;
  to["regressions"] = regressions;
}

/// The report of one spec.
Json check_json(const SpecCheck& check) {
  Json j = analysis_header(check.analysis, "check");
  j["requirements"] = requirements_json(check);
  if (check.baseline) add_baseline(*check.baseline, j);
  j["met"] = check.all_met();
  j["warnings"] = check.analysis.warnings;
  return j;
}

}  // namespace

/// Of one spec its report; of several a list of such reports.
std::string to_json(const CheckReport& report, const Style&) {
  if (report.specs.size() == 1 && report.broken.empty()) return check_json(report.specs.front()).document();
  Json list = Json::array();
  for (const SpecCheck& check : report.specs) list.push_back(check_json(check));
  Json broken = Json::array();
  for (const BrokenSpec& b : report.broken) broken.push_back({{"file", b.file}, {"error", b.error.what()}});
  Json j = {{"qerr", version()}, {"command", "check"}};
  j["reports"] = list;
  j["broken"] = broken;
  j["met"] = report.all_met();
  return j.document();
}

}  // namespace qerr
