#include "report/csv_text.hpp"
#include "report/formats.hpp"
#include "report/plan/parts.hpp"

namespace qerr {

namespace {

void add_rows(std::string& out, const char* motion, const std::vector<PlannedJoint>& joints) {
  for (const PlannedJoint& joint : joints)
    for (const PlannedEffect& p : joint.effects) {
      std::string twins;
      for (const CorrelatedEffect& r : p.correlated)
        if (r.inseparable()) twins += (twins.empty() ? "" : "; ") + family_of(r.effect);
      const auto shaft = p.effect.choices.find("shaft");
      out += std::string(motion) + ',' + csv_cell(joint.joint) + ',' + p.effect.type + ',' +
             (shaft == p.effect.choices.end() ? "" : shaft->second) + ',' +
             (p.effect.numbers.contains("order") ? shortest(p.effect.number("order")) : "") + ',' +
             (p.effect.numbers.contains("time_constant") ? shortest(p.effect.number("time_constant")) : "") +
             ',' + p.parameter + ',' + csv_number(p.detectable) + ',' + csv_number(p.identifiable) + ',' +
             size_unit(p, joint.prismatic) + ',' + csv_number(p.detectable_counts()) + ',' +
             csv_number(p.identifiable_counts()) + ',' + csv_cell(twins) + "\r\n";
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
