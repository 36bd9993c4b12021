#include "qerr/report/diagnosis_report.hpp"

#include <algorithm>

#include "qerr/effect/effect_kind.hpp"
#include "report/diagnosis/parts.hpp"

namespace qerr {

std::optional<std::size_t> joint_place(const Spec& spec, const std::string& name) {
  const auto& joints = spec.model.chain.independent;
  const auto found =
      std::find_if(joints.begin(), joints.end(), [&](const auto& j) { return j.name == name; });
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
  for (const std::string& text : diagnosis.warnings)
    if (std::find(warnings.begin(), warnings.end(), text) == warnings.end()) warnings.push_back(text);
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

}  // namespace qerr
