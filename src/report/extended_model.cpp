#include "diagnosis_writers.hpp"
#include "qerr/input/extended_spec.hpp"
#include "text_table.hpp"

namespace qerr {

namespace {

std::string note(const Spec& spec, const Cause& cause) {
  std::string text = cause.effect.type + " of " + escaped(cause.effect.joint, 60);
  for (const ReportedParameter& p : reported_parameters(spec, cause))
    if (!p.fixed) text += ", " + p.figure.name + ' ' + with_interval(p);
  return text;
}

}  // namespace

std::string extended_model(const DiagnosisReport& r, const std::string& target) {
  const Diagnosis& d = r.diagnosis;
  const std::string unit = gain_unit(d);
  std::string remarks = "qerr diagnose " + std::string(version()) + " of " + escaped(r.log.file) + ": " +
                        std::string(name(d.verdict));
  if (d.causes.empty()) return extended_spec(r.spec, {}, remarks + ", no effects to add", target);
  remarks += ", residual " + readable(d.gain.rms_before, unit) + " -> " + readable(d.gain.rms_after, unit) +
             (d.gain.held_out ? " (held out)" : "");
  std::vector<AddedEffect> effects;
  for (const Cause& cause : d.causes) effects.push_back({cause.effect, note(r.spec, cause)});
  return extended_spec(r.spec, effects, remarks, target);
}

}  // namespace qerr
