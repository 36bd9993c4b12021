#include "qerr/report/simulation_report.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/text.hpp"
#include "kinematics/inverse_dynamics.hpp"
#include "qerr/report/analysis.hpp"
#include "qerr/report/filter_report.hpp"
#include "report/analysis/count_rates.hpp"
#include "report/analysis/effects.hpp"
#include "report/analysis/tables.hpp"
#include "report/simulation/parts.hpp"
#include "simulate/sensing.hpp"
#include "simulate/settling.hpp"

namespace qerr {

std::vector<NamedSignal> signals_of(const SimulationReport& r) {
  std::vector<NamedSignal> all;
  for (std::size_t o = 0; o < r.simulation.results.size(); ++o) {
    const NamedFilter* filter = o == 0 ? nullptr : &r.spec.filters[o - 1];
    for (std::size_t c = 0; c < r.simulation.results[o].size(); ++c) {
      const Signal s = signal_of(r.spec.model.coordinates[c]);
      all.push_back({r.simulation.results[o][c], filter ? filter->name : "position", s.name,
                     filter ? derivative_unit(s.unit, filter->filter) : s.unit,
                     filter ? shown_unit(s.unit, filter->filter) : s.unit});
    }
  }
  return all;
}

namespace {

/// A motion that ends before its filters have settled, so that their transients are in the figures.
void warn_of_a_short_motion(const SimulationReport& r, std::vector<std::string>& warnings) {
  Motion endless = *r.spec.motion;
  endless.duration = std::numeric_limits<double>::infinity();
  const double needed = settling_time(endless, designed_filters(r.spec)),
               discarded = static_cast<double>(r.simulation.settling) / endless.sample_rate;
  if (needed > discarded + 2 / endless.sample_rate)
    warnings.push_back("the figures contain transients of the filters: these take " + readable(needed, "s") +
                       ", and of a motion so short only the first " + readable(discarded, "s") +
                       " are discarded; make motion.duration at least " + readable(2 * needed, "s"));
}

/// The figures that are missing from the report, or wrong in it, with the reason.
std::vector<std::string> warnings_of(const SimulationReport& r, bool exact) {
  std::vector<std::string> warnings;
  warn_of_a_short_motion(r, warnings);
  const bool without_exact = std::any_of(
      r.simulation.results.begin(), r.simulation.results.end(), [](const std::vector<SimulatedSignal>& row) {
        return std::any_of(row.begin(), row.end(),
                           [](const SimulatedSignal& s) { return std::isnan(s.sigma_exact); });
      });
  if (exact && without_exact)
    warnings.emplace_back(
        "sigma at the speeds of the motion is not given: an encoder moves by less than a quarter of a count; "
        "`analyze` has it, as sigma in motion");
  const auto& positions = r.simulation.results[0];
  if (std::any_of(positions.begin(), positions.end(), [](const SimulatedSignal& s) {
        return std::isinf(s.sigma_ipqn) || std::isinf(s.sigma_ipqn_path);
      }))
    warnings.push_back(
        "Euler angles: the motion passes the gimbal lock (pitch = +-90 deg), where they have no bound; use "
        "rx ry rz");
  return warnings;
}

}  // namespace

SimulationReport simulation_report(const Spec& all, const SimulationOptions& options) {
  Spec spec = all;  // what is simulated are coordinates of the tip
  if (const auto removed =
          std::erase_if(spec.filters, [](const NamedFilter& f) { return !f.joints.empty(); }))
    spec.warnings.push_back(counted(removed, "filter") +
                            " of joints or controllers: not simulated; `analyze` has their figures");
  if (!spec.motion)
    throw Error(Fault{{spec.file, 1, 1},
                      "motion",
                      "the spec has no motion to simulate",
                      "",
                      "add motion: {sample_rate: 1 kHz, duration: 10 s, joints: {...}}"});
  if (needs_effort(spec.effects) && !has_masses(spec.model.chain))
    throw Error(Fault{{spec.file, 1, 1},
                      "effects",
                      "compliance needs a load, which the URDF does not determine",
                      "no <inertial> between base and tip",
                      "give the links their masses"});
  if (spec.model.tips)
    spec.warnings.emplace_back(
        "of several tips none is compared with the simulation: give the spec one `robot.tip`");
  const EffectReport effects = effects_by_range(spec);
  OperationalModel model = spec.model;
  model.sources = effects.sources;
  SimulationReport report{
      spec, simulate(model, designed_filters(spec), filter_norms(spec), *spec.motion, spec.effects, options),
      options.seed, spec.warnings};
  for (std::string& text : effect_warnings(spec, effects.shares)) report.warnings.push_back(std::move(text));
  if (states_accuracy(spec))
    report.warnings.emplace_back(
        "the encoders' `accuracy` is not simulated, and not in the theory beside it: the shape of the error "
        "is "
        "not known; an effect such as eccentricity has one");
  for (std::string& text : filter_warnings(spec)) report.warnings.push_back(std::move(text));
  for (std::string& text : count_rate_warnings(spec)) report.warnings.push_back(std::move(text));
  for (std::string& text : warnings_of(report, options.exact)) report.warnings.push_back(std::move(text));
  return report;
}

}  // namespace qerr
