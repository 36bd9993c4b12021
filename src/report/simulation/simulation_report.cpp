#include "qerr/report/simulation_report.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "kinematics/inverse_dynamics.hpp"
#include "qerr/report/effect_report.hpp"
#include "qerr/report/write.hpp"
#include "report/report_json.hpp"
#include "report/simulation/simulation_writers.hpp"
#include "simulate/sensing.hpp"

namespace qerr {

namespace {

using Json = nlohmann::ordered_json;
using Figures = std::vector<std::pair<const char*, double>>;

Figures figures_of(const SimulatedSignal& s) {
  return {{"sigma_simulated", s.sigma_simulated}, {"sigma_lower", s.sigma_lower},
          {"sigma_upper", s.sigma_upper},         {"mean_simulated", s.mean_simulated},
          {"peak_simulated", s.peak_simulated},   {"sigma_ipqn", s.sigma_ipqn},
          {"sigma_ipqn_path", s.sigma_ipqn_path}, {"sigma_exact", s.sigma_exact},
          {"worst_case", s.worst_case},           {"worst_case_path", s.worst_case_path}};
}

Figures factors_of(const Ladder& l) {
  return {{"varying_jacobian", l.varying_jacobian},
          {"joint_error", l.joint_error},
          {"correlated_joints", l.correlated_joints},
          {"nonlinear", l.nonlinear}};
}

Json json_of(const NamedSignal& s) {
  Json row = {{"filter", s.filter}, {"coordinate", s.coordinate}, {"unit", s.unit}};
  for (const auto& [name, value] : figures_of(s.signal)) row[name] = number_or_null(value);
  for (const auto& [name, value] : factors_of(s.signal.ladder)) row["ladder"][name] = number_or_null(value);
  return row;
}

std::string json(const SimulationReport& r) {
  Json effects = Json::array();
  for (const Effect& effect : r.spec.effects) {
    Json row = {{"effect", effect.type}, {"joint", effect.joint}};
    for (const EffectParameter& p : effect_parameters(r.spec, effect)) row[p.name] = p.value;
    for (const auto& [name, choice] : effect.choices) row[name] = choice;
    effects.push_back(row);
  }
  Json j = report_header(r.spec, "simulate", r.seed);
  j["effects"] = effects;
  j["runs"] = r.simulation.runs;
  j["samples"] = r.simulation.samples;
  j["settling_samples"] = r.simulation.settling;
  j["results"] = Json::array();
  for (const NamedSignal& s : signals_of(r)) j["results"].push_back(json_of(s));
  j["warnings"] = r.warnings;
  return j.dump(2) + "\n";
}

/// The ladder stands beside the figures.
Figures cells_of(const SimulatedSignal& s) {
  Figures all = figures_of(s);
  for (const auto& factor : factors_of(s.ladder)) all.push_back(factor);
  return all;
}

std::string csv(const SimulationReport& r) {
  std::string out = "filter,coordinate,unit";
  for (const auto& cell : cells_of({})) out += ',' + std::string(cell.first);
  out += "\r\n";
  for (const NamedSignal& s : signals_of(r)) {
    out += csv_cell(s.filter) + ',' + s.coordinate + ',' + s.unit;
    for (const auto& [name, value] : cells_of(s.signal))
      out += ',' + (std::isfinite(value) ? shortest(value) : std::string());
    out += "\r\n";
  }
  return out;
}

}  // namespace

std::vector<NamedSignal> signals_of(const SimulationReport& r) {
  std::vector<NamedSignal> all;
  for (std::size_t o = 0; o < r.simulation.results.size(); ++o) {
    const NamedFilter* filter = o == 0 ? nullptr : &r.spec.filters[o - 1];
    for (std::size_t c = 0; c < r.simulation.results[o].size(); ++c) {
      const Coordinate coordinate = r.spec.model.coordinates[c];
      all.push_back({r.simulation.results[o][c], filter ? filter->name : "position",
                     std::string(info(coordinate).name),
                     derivative_unit(coordinate, filter ? filter->filter.derivative : 0)});
    }
  }
  return all;
}

namespace {

/// Figures that the report lacks, and why.
std::vector<std::string> warnings_of(const SimulationReport& r) {
  std::vector<std::string> warnings;
  for (std::size_t f = 0; f < r.spec.filters.size(); ++f) {
    const auto& row = r.simulation.results[f + 1];
    if (std::any_of(row.begin(), row.end(),
                    [](const SimulatedSignal& s) { return std::isnan(s.sigma_exact); }))
      warnings.push_back("filter '" + r.spec.filters[f].name +
                         "' remembers too many samples for sigma at the speeds of the motion: only IPQN is "
                         "given");
  }
  const auto& positions = r.simulation.results[0];
  if (std::any_of(positions.begin(), positions.end(), [](const SimulatedSignal& s) {
        return std::isinf(s.sigma_ipqn) || std::isinf(s.sigma_ipqn_path);
      }))
    warnings.push_back(
        "roll and yaw: the motion meets the gimbal lock (pitch = +-90 deg), where there is no theory of "
        "them; "
        "use rx ry rz");
  return warnings;
}

}  // namespace

SimulationReport simulation_report(const Spec& spec, const SimulationOptions& options) {
  if (!spec.motion)
    throw Error(Fault{{spec.file, 1, 1},
                      "motion",
                      "the spec has no motion to simulate",
                      "",
                      "add motion: {sample_rate: 1 kHz, duration: 10 s, joints: {...}}"});
  if (needs_effort(spec.effects) && !has_masses(spec.model.chain))
    throw Error(Fault{{spec.file, 1, 1},
                      "effects",
                      "compliance winds up under a load that the URDF does not tell",
                      "no <inertial> between base and tip",
                      "give the links their masses"});
  const EffectReport effects = effect_report(spec);
  OperationalModel model = spec.model;
  model.sources = effects.sources;
  SimulationReport report{
      spec, simulate(model, designed_filters(spec), filter_norms(spec), *spec.motion, spec.effects, options),
      options.seed, spec.warnings};
  for (std::string& text : effect_warnings(spec, effects.shares)) report.warnings.push_back(std::move(text));
  for (std::string& text : warnings_of(report)) report.warnings.push_back(std::move(text));
  return report;
}

std::string write(const SimulationReport& r, std::string_view format, const Style&) {
  return format == "json" ? json(r) : format == "csv" ? csv(r) : simulation_table(r);
}

}  // namespace qerr
