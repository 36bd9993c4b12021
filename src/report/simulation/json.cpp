#include "report/analysis/effects.hpp"
#include "report/formats.hpp"
#include "report/json_header.hpp"
#include "report/simulation/cutoffs.hpp"
#include "report/simulation/signals.hpp"

namespace qerr {

namespace {

Json json_of(const NamedSignal& s) {
  Json row = {{"filter", s.filter}, {"coordinate", s.coordinate}, {"unit", s.unit}};
  for (const auto& [name, value] : figures_of(s.signal)) row[name] = value;
  for (const auto& [name, value] : factors_of(s.signal.ladder)) row["ladder"][name] = value;
  return row;
}

Json cutoffs(const SimulationReport& r) {
  const std::vector<CutoffChoice> choices = cutoff_choices(r);
  Json list = Json::array();
  for (const CutoffChoice& c : choices)
    list.push_back({{"cutoff", c.cutoff},
                    {"encoder_rms", c.noise},
                    {"tracking_rms", c.tracking},
                    {"total_rms", c.total}});
  return {{"filter", r.cutoffs->filter},
          {"unit", cutoff_unit(r)},
          {"best", choices[best_of(choices)].cutoff},
          {"choices", list}};
}

}  // namespace

std::string to_json(const SimulationReport& r, const Style&) {
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
  if (r.cutoffs) j["cutoffs"] = cutoffs(r);
  j["warnings"] = r.warnings;
  return j.document();
}

}  // namespace qerr
