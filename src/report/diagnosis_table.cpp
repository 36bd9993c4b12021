#include "diagnosis_writers.hpp"
#include "text_table.hpp"

namespace qerr {

std::string to_table(const DiagnosisReport& r, const Style&) {
  std::string out = "verdict: " + std::string(name(r.diagnosis.verdict)) + '\n';
  for (const Cause& c : r.diagnosis.causes) {
    out += "  " + c.effect.type + " at " + escaped(c.effect.joint, 60);
    for (const ReportedParameter& p : reported_parameters(r.spec, c))
      out += ", " + p.figure.name + ' ' + readable(p.figure.value, p.unit);
    out += '\n';
  }
  return out;
}

}  // namespace qerr
