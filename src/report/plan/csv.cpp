#include "report/csv_text.hpp"
#include "report/formats.hpp"
#include "report/plan/parts.hpp"

namespace qerr {

namespace {

void add_rows(std::string& out, const char* motion, const std::vector<PlannedJoint>& joints) {
  for (const PlannedJoint& joint : joints) {
    const Json json = json_of(joint);
    for (std::size_t i = 0; i < joint.effects.size(); ++i) {
      std::string twins;
      for (const CorrelatedEffect& r : joint.effects[i].correlated)
        if (r.inseparable()) twins += (twins.empty() ? "" : "; ") + family_of(r.effect);
      out += std::string(motion) + ',' + csv_cell(joint.joint) + ',' +
             csv_cells((*json.find("effects")->items())[i],
                       {"effect", "shaft", "order", "time_constant", "parameter", "seen", "named", "unit",
                        "seen_counts", "named_counts"}) +
             ',' + csv_cell(twins) + "\r\n";
    }
  }
}

}  // namespace

std::string to_csv(const PlanReport& r, const Style&) {
  std::string out =
      "motion,joint,effect,shaft,order,time_constant,parameter,seen,named,unit,seen_counts,named_counts,"
      "cannot_be_told_from\r\n";
  add_rows(out, "planned", r.plan.joints);
  add_rows(out, "better", r.plan.joints_better);
  return out;
}

}  // namespace qerr
