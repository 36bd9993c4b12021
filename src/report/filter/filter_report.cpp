#include "qerr/report/filter_report.hpp"

#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "qerr/core/error.hpp"
#include "qerr/core/quantity.hpp"
#include "report/filter/noise.hpp"

namespace qerr {

namespace {

FilterFigures figures_of(const NamedFilter& named, const FilterQuestions& q) {
  const Filter& filter = named.filter;
  FilterFigures f{named.name,
                  filter,
                  named.norms,
                  group_delay(filter),
                  poles_max_modulus(filter),
                  bandwidth(filter),
                  estimates_its_derivative(filter) ? std::optional(noise_bandwidth(filter, named.norms.h2))
                                                   : std::nullopt,
                  settling_time(filter),
                  {},
                  {},
                  named.designed};
  for (const double frequency : q.frequencies) f.fidelity.push_back(fidelity(filter, frequency));
  if (q.motion_band) f.tracking = band_tracking(filter, q.motion_band->first, q.motion_band->second);
  return f;
}

/// What a filter that does not estimate its derivative does. @param gain  at low frequencies, not 1
std::string instead(double gain) {
  if (std::isinf(gain)) return " and estimates a lower one: its gain grows without bound at low frequencies";
  const std::string yields = ", and at low frequencies yields " + significant(gain, 4) + " of it: ";
  return yields + (gain < -0.5 && gain > -2 ? "is the sign of its numerator right?"
                                            : "are its coefficients scaled by 1/T?");
}

}  // namespace

std::vector<std::string> filter_warnings(const Spec& spec) {
  std::vector<std::string> warnings;
  for (const NamedFilter& f : spec.filters) {
    const int d = f.filter.derivative;
    if (f.filter.unit && *f.filter.unit != Dimension{.second = -d}) continue;  // a control law
    if (has_unknown_unit(f.filter))
      warnings.push_back(
          "filter '" + f.name +
          "' states no derivative, and passes constants scaled by H(1) = " + significant(f.norms.dc_gain, 4) +
          ": its output has no unit here; write unit: N m/rad (or another one) for a control law, "
          "derivative: 0 for an estimate of the position, or is its numerator right?");
    else if (d == 0 && std::abs(f.norms.dc_gain - 1) > 0.01)
      warnings.push_back("filter '" + f.name +
                         "' estimates a position, and passes constants scaled by H(1) = " +
                         significant(f.norms.dc_gain, 4) + ": is its numerator right?");
    if (d == 0) continue;
    const std::string stated =
        "filter '" + f.name + "' is specified to estimate derivative " + std::to_string(d);
    if (std::abs(f.norms.dc_gain) > 1e-9 * f.norms.h2)
      warnings.push_back(stated + " and passes constants: H(1) = " + significant(f.norms.dc_gain, 4));
    else if (!estimates_its_derivative(f.filter))
      warnings.push_back(stated + instead(low_frequency_gain(f.filter)));
    else if (!passes_slow_motion(f.filter))
      warnings.push_back("filter '" + f.name + "' passes slow motion with a gain of " +
                         significant(low_frequency_gain(f.filter), 4) +
                         ", and its noise with it: divide both by the gain before you compare filters");
  }
  return warnings;
}

FilterReport filter_report(const Spec& spec, const FilterQuestions& q) {
  FilterReport report{spec, q, {}, {}};
  if (q.noise || !q.motions.empty()) report.noise = noise_report(spec, q.motions);
  report.sine_errors = sine_errors(spec, q.motions);
  for (const NamedFilter& named : spec.filters) {
    double highest = q.motion_band ? q.motion_band->second : 0;
    for (const double f : q.frequencies) highest = std::max(highest, f);
    for (const MotionQuestion& m : q.motions) highest = std::max(highest, m.frequency);
    if (highest > 0.5 * named.filter.sample_rate)
      throw Error({{spec.file, 0, 0},
                   "filters." + named.name + ".sample_rate",
                   "a frequency that the command line asks for lies above half of the sample rate",
                   shortest(highest) + " Hz at " + shortest(named.filter.sample_rate) + " Hz",
                   "ask for frequencies up to " + shortest(0.5 * named.filter.sample_rate) + " Hz"},
                  Trouble::usage);
    report.filters.push_back(figures_of(named, q));
  }
  if (q.estimators) report.estimators = estimator_report(spec, q.clock);
  report.warnings = spec.warnings;
  for (std::string& warning : filter_warnings(spec)) report.warnings.push_back(std::move(warning));
  return report;
}

}  // namespace qerr
