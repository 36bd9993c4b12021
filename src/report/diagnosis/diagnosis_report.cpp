#include "qerr/report/diagnosis_report.hpp"

#include <algorithm>

#include "core/text.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "qerr/input/spec.hpp"
#include "report/diagnosis/parts.hpp"
#include "report/text_table.hpp"

namespace qerr {

std::optional<std::size_t> joint_place(const Spec& spec, const std::string& name) {
  const auto& joints = spec.model.chain.independent;
  const auto found = std::ranges::find(joints, name, &IndependentJoint::name);
  if (found == joints.end()) return std::nullopt;
  return static_cast<std::size_t>(found - joints.begin());
}

const Encoder* encoder_of(const Spec& spec, const std::string& joint) {
  const auto place = joint_place(spec, joint);
  return place ? &spec.model.transmission.encoders[*place] : nullptr;
}

std::string figure_unit(const Spec& spec, const Unidentified& u, const std::string& figure) {
  const std::string coordinate = coordinate_unit(spec, u.joint);
  if (figure == "time" || figure == "time_constant" || figure == "duration") return "s";
  if (figure == "frequency") return "Hz";
  if (figure == "divisor") return "counts";
  if (figure == "rate") return coordinate + "/s";
  if (figure == "order") return coordinate == "m" ? "1/m" : "";
  return coordinate;
}

namespace {

/// A log without its values.
Log described(const Log& log) {
  return {log.file,      log.columns,      log.rows,     log.first_time,
          log.last_time, log.time_origin,  log.warnings, {},
          log.stretches, log.stretch_rows, {},           log.misspelt};
}

}  // namespace

DiagnosisReport diagnosis_report(const Spec& spec, Log log, const DiagnoseOptions& options,
                                 bool keep_values) {
  std::vector<Filter> filters;
  for (const NamedFilter& f : spec.filters)
    if (!f.controller) filters.push_back(f.filter);
  Log judged = keep_values ? log : std::move(log);
  if (!keep_values) log = described(judged);
  Diagnosis diagnosis = diagnose(spec.model, filters, spec.effects, std::move(judged), options);
  std::vector<std::string> warnings = spec.warnings;
  warnings.insert(warnings.end(), log.warnings.begin(), log.warnings.end());
  for (const std::string& text : diagnosis.warnings) add_once(warnings, text);
  return {spec, std::move(log), std::move(diagnosis), "", std::move(warnings)};
}

std::string coordinate_unit(const Spec& spec, const std::string& name) {
  if (const auto joint = joint_place(spec, name))
    return spec.model.chain.independent[*joint].prismatic() ? "m" : "rad";
  for (const CoordinateInfo& row : coordinate_list())
    if (name == row.name || name == "tip." + std::string(row.name)) return std::string(row.unit);
  return "m";
}

std::vector<ReportedParameter> reported_parameters(const Spec& spec, const Cause& cause) {
  std::vector<ReportedParameter> list;
  const auto joint = joint_place(spec, cause.effect.joint);
  const bool prismatic = joint && spec.model.chain.independent[*joint].prismatic();
  const auto add = [&](const std::string& name, const std::string& unit) {
    for (const FoundParameter& p : cause.parameters)
      if (p.name == name) return list.push_back({p, unit, p.lower == p.upper});
    const auto number = cause.effect.numbers.find(name);
    if (number != cause.effect.numbers.end())
      list.push_back({{name, number->second, number->second, number->second}, unit, true});
  };
  const auto is_listed = [&](const std::string& name) {
    return std::any_of(list.begin(), list.end(), [&](const auto& p) { return p.figure.name == name; });
  };
  for (const Parameter& row : effect_kind(cause.effect.type).parameters)
    add(std::string(row.name), unit_name(dimension_at(row, prismatic)));
  for (const FoundParameter& p : cause.parameters)
    if (!is_listed(p.name)) add(p.name, "");
  for (const auto& [name, value] : cause.effect.numbers)
    if (!is_listed(name)) add(name, "");
  return list;
}

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
