#include <algorithm>

#include "core/text.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "qerr/input/extended_spec.hpp"
#include "report/diagnosis/parts.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

std::string note(const Spec& spec, const Cause& cause) {
  std::string text = cause.effect.type + " of " + escaped(cause.effect.joint, 60);
  for (const ReportedParameter& p : reported_parameters(spec, cause))
    if (!p.fixed) text += ", " + p.figure.name + ' ' + with_interval(p);
  return text;
}

/// Whether a spec can state the filter: a low-pass without an additional delay.
bool is_filter(const Effect& e) {
  return effect_kind(e.type).is_filter && e.choices.count("family") && e.number_or("order", 0) > 0 &&
         e.number_or("delay", 0) == 0;
}

std::string free_name(const Spec& spec, const std::vector<AddedFilter>& added, const std::string& wanted) {
  const auto taken = [&](const std::string& name) {
    const auto has = [&](const auto& f) { return f.name == name; };
    return std::any_of(spec.filters.begin(), spec.filters.end(), has) ||
           std::any_of(added.begin(), added.end(), has);
  };
  std::string name = wanted;
  for (int i = 2; taken(name); ++i) name = wanted + '_' + std::to_string(i);
  return name;
}

/// The filters that computed the velocities of the log. If none of the velocities is of the spec's only
/// filter, the first one replaces it; the others are added.
std::vector<AddedFilter> found_filters(const DiagnosisReport& r) {
  std::vector<AddedFilter> filters;
  std::vector<std::string> stated;
  for (const NamedFilter& f : r.spec.filters)
    if (f.filter.derivative == 1) stated.push_back(f.name);
  const auto& columns = r.log.columns;
  const auto velocities = std::count_if(columns.begin(), columns.end(),
                                        [](const LogColumn& c) { return c.signal == LogSignal::velocity; });
  const auto& causes = r.diagnosis.causes;
  const auto others =
      std::count_if(causes.begin(), causes.end(), [](const Cause& c) { return is_filter(c.effect); });
  for (const Cause& c : causes) {
    if (!is_filter(c.effect) || stated.empty()) continue;
    const bool instead = filters.empty() && stated.size() == 1 && others == velocities;
    const std::string name =
        instead ? stated[0] : free_name(r.spec, filters, stated[0] + '_' + c.effect.joint);
    filters.push_back({name, c.effect.choices.at("family"), static_cast<int>(c.effect.number("order")),
                       c.effect.number("cutoff"), note(r.spec, c)});
  }
  return filters;
}

}  // namespace

std::string extended_model(const DiagnosisReport& r, const std::string& target) {
  const Diagnosis& d = r.diagnosis;
  const std::string& unit = d.gain.unit;
  std::string remarks = "qerr diagnose " + std::string(version()) + " of " + escaped(r.log.file) + ": " +
                        std::string(name(d.verdict));
  if (d.causes.empty()) return extended_spec(r.spec, {}, remarks + ", no effects to add", target);
  remarks += ", residual " + readable(d.gain.rms_before, unit) + " -> " + readable(d.gain.rms_after, unit) +
             (d.gain.held_out ? " (held out)" : "");
  std::vector<AddedEffect> effects;
  for (const Cause& cause : d.causes)
    if (!is_filter(cause.effect)) effects.push_back({cause.effect, note(r.spec, cause)});
  return extended_spec(r.spec, effects, remarks, target, found_filters(r));
}

}  // namespace qerr
