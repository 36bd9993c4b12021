#include "report/analysis/effects.hpp"
#include "report/csv_text.hpp"
#include "report/formats.hpp"
#include "report/json_header.hpp"
#include "report/simulation/parts.hpp"

namespace qerr {

namespace {

using Cutoffs = In<CutoffSearch, SimulationReport>;
using ReportedEstimate = In<EstimatedVelocity, SimulationReport>;

/// An effect with its parameters beside its type.
Json reported_effects(const SimulationReport& r) {
  Json effects = Json::array();
  for (const Effect& effect : r.spec.effects) {
    Json entry = {{"effect", effect.type}, {"joint", effect.joint}};
    for (const EffectParameter& p : effect_parameters(r.spec, effect)) entry[p.name] = p.value;
    for (const auto& [name, choice] : effect.choices) entry[name] = choice;
    effects.push_back(entry);
  }
  return effects;
}

Schema effects_schema() {
  Json effect = schema_of(RowsOf<Effect>{{"effect", &Effect::type}, {"joint", &Effect::joint}}.list);
  effect["additionalProperties"] = {{"type", Json::array({"number", "string", "null"})}};
  return {schema::list(effect)};
}

}  // namespace

RowsOf<Ladder> rows(Of<Ladder>) {
  return {{"varying_jacobian", &Ladder::varying_jacobian, nullable},
          {"joint_error", &Ladder::joint_error, nullable},
          {"correlated_joints", &Ladder::correlated_joints, nullable},
          {"nonlinear", &Ladder::nonlinear, nullable}};
}

RowsOf<NamedSignal> rows(Of<NamedSignal>) {
  return {{"filter", &NamedSignal::filter, "\"position\" or the filter's name"},
          {"coordinate", &NamedSignal::coordinate},
          {"unit", &NamedSignal::unit},
          {"sigma_simulated", &SimulatedSignal::sigma_simulated, nullable},
          {"sigma_lower", &SimulatedSignal::sigma_lower, nullable},
          {"sigma_upper", &SimulatedSignal::sigma_upper, nullable},
          {"mean_simulated", &SimulatedSignal::mean_simulated, nullable},
          {"peak_simulated", &SimulatedSignal::peak_simulated, nullable},
          {"sigma_ipqn", &SimulatedSignal::sigma_ipqn, nullable},
          {"sigma_ipqn_path", &SimulatedSignal::sigma_ipqn_path, nullable},
          {"sigma_exact", &SimulatedSignal::sigma_exact, nullable},
          {"worst_case", &SimulatedSignal::worst_case, nullable},
          {"worst_case_path", &SimulatedSignal::worst_case_path, nullable},
          {"tracking_rms", &SimulatedSignal::tracking_rms, nullable},
          {"tracking_peak", &SimulatedSignal::tracking_peak, nullable},
          {"total_rms", &SimulatedSignal::total_rms, nullable},
          {"ladder", &SimulatedSignal::ladder, "factors from sigma_ipqn to sigma_simulated"}};
}

RowsOf<CutoffChoice> rows(Of<CutoffChoice>) {
  return {{"cutoff", &CutoffChoice::cutoff, "[Hz]"},
          {"encoder_rms", &CutoffChoice::noise, "by the errors of the encoders"},
          {"tracking_rms", &CutoffChoice::tracking, "by the filter"},
          {"total_rms", &CutoffChoice::total}};
}

RowsOf<Cutoffs> rows(Of<Cutoffs>) {
  return {{"filter", &CutoffSearch::filter},
          {"unit", [](auto& c) { return cutoff_unit(c.whole); }, "of the errors"},
          {"best",
           [](auto& c) {
             const std::vector<CutoffChoice> choices = cutoff_choices(c.whole);
             return choices[best_of(choices)].cutoff;
           },
           "the cut-off with the least total [Hz]"},
          {"choices", [](auto& c) { return cutoff_choices(c.whole); },
           "of the vector of the position's coordinates"}};
}

RowsOf<ErrorAtSpeed> rows(Of<ErrorAtSpeed>) {
  return {{"speed", &ErrorAtSpeed::speed}, {"rms", &ErrorAtSpeed::rms}};
}

RowsOf<ReportedEstimate> rows(Of<ReportedEstimate>) {
  using Estimated = EstimatedVelocity;
  return {{"estimator", &Estimated::estimator, "name in the spec"},
          {"kind", &Estimated::kind, "of `qerr list estimators`, or filter"},
          {"coordinate", [](auto& e) { return e.whole.spec.model.chain.independent[e->joint].name; },
           "the joint"},
          {"unit", [](auto& e) { return speed_unit(e.whole, *e); }},
          {"rms", &Estimated::rms, "of the estimate minus the true velocity"},
          {"noise", &Estimated::noise, "rms about the true velocity at the delay"},
          {"tracking", &Estimated::tracking, "rms of what the delay makes"},
          {"delay", &Estimated::delay, "that fits best [s]"},
          {"worst", &Estimated::worst, "largest error along the motion"},
          {"worst_case", &Estimated::worst_case, "bound of what the counts add; null: none is known"},
          {"by_speed", &Estimated::by_speed, "rms in classes of the speed"}};
}

RowsOf<SimulationReport> rows(Of<SimulationReport>) {
  return spec_header<SimulationReport>("simulate")
      .with({{"effects", reported_effects, effects_schema()},
             {"runs", [](auto& r) { return r.simulation.runs; }},
             {"samples", [](auto& r) { return r.simulation.samples; }, "of a run"},
             {"settling_samples", [](auto& r) { return r.simulation.settling; }, "discarded at the start"},
             {"results", signals_of},
             {"cutoffs", within(&SimulationReport::cutoffs), "with --cutoffs", optional},
             {"estimators", [](auto& r) { return items_of(r.estimators, r); },
              "with --estimators: of each joint the least error first", optional},
             {"warnings", &SimulationReport::warnings}});
}

std::string to_csv(const SimulationReport& r, const Style&) {
  return r.estimators.empty() ? csv_of(signals_of(r)) : estimator_csv(r);
}

}  // namespace qerr
