#pragma once

#include <string>
#include <utility>
#include <vector>

#include "qerr/report/diagnosis_report.hpp"
#include "qerr/report/write.hpp"

/// Diagnoses made by hand.
namespace qerr {

/// A robot with a prismatic and revolute joints.
inline Spec spec() { return read_spec(std::string(QERR_SOURCE_DIR) + "/configs/planar_prr/spec.yaml"); }

inline std::string joint_of(const Spec& s, bool prismatic) {
  for (const IndependentJoint& j : s.model.chain.independent)
    if (j.prismatic() == prismatic) return j.name;
  return "";
}

inline Cause cause(const std::string& type, const std::string& joint,
                   std::vector<FoundParameter> parameters) {
  Cause c;
  c.effect = {type, joint, {}, {}};
  c.parameters = std::move(parameters);
  c.p_value = 1e-12;
  for (const FoundParameter& p : c.parameters) c.effect.numbers[p.name] = p.value;
  c.gain = {5e-4, 3e-5, true, 14, 19, 5, 0.3, 1.02, 0.4, 0.95, coordinate_unit(spec(), joint)};
  return c;
}

inline DiagnosisReport report(Verdict verdict, std::vector<Cause> causes) {
  DiagnosisReport r{spec(), {}, {}, "", {}};
  r.log.file = "log.csv";
  r.diagnosis.verdict = verdict;
  r.diagnosis.causes = std::move(causes);
  r.diagnosis.gain = {5e-4, 3e-5, true, 14, 19, 5, 0.3, 1.02, 0.4, 0.95};
  return r;
}

inline std::string table(const DiagnosisReport& r) { return write(r, "table", Style{.width = 200}); }

}  // namespace qerr
