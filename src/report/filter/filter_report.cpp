#include "qerr/report/filter_report.hpp"

#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "qerr/report/write.hpp"
#include "report/filter/estimator_json.hpp"
#include "report/filter/filter_writers.hpp"
#include "report/filter/noise_json.hpp"
#include "report/report_json.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

using Json = nlohmann::ordered_json;

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
                  {}};
  for (const double frequency : q.frequencies) f.fidelity.push_back(fidelity(filter, frequency));
  if (q.motion_band) f.tracking = band_tracking(filter, q.motion_band->first, q.motion_band->second);
  return f;
}

Json to_json(const FilterFigures& f, bool coefficients) {
  Json j = {{"name", f.name},
            {"derivative", f.filter.derivative},
            {"sample_rate", f.filter.sample_rate},
            {"h2_norm", f.norms.h2},
            {"h2_error", f.norms.h2_error},
            {"l1_norm", {{"lower", f.norms.l1.lower}, {"upper", f.norms.l1.upper}}},
            {"dc_gain", f.norms.dc_gain},
            {"group_delay_s", f.group_delay},
            {"poles_max_modulus", f.poles_max_modulus},
            {"bandwidth_hz", number_or_null(f.bandwidth)},
            {"noise_bandwidth_hz", number_or_null(f.noise_bandwidth)},
            {"settling_time_s", number_or_null(f.settling_time)}};
  for (const Fidelity& at : f.fidelity)
    j["at"].push_back({{"frequency", at.frequency},
                       {"gain_error", at.gain_error},
                       {"phase_error", at.phase_error},
                       {"tracking_error", at.tracking_error}});
  if (f.tracking) j["motion_band"] = {{"largest", f.tracking->largest}, {"rms", f.tracking->rms}};
  if (coefficients && f.filter.taps.empty()) j["sections"] = second_order_sections(f.filter);
  if (coefficients && !f.filter.taps.empty()) j["taps"] = impulse_response(f.filter, f.filter.taps.size());
  return j;
}

}  // namespace

std::vector<std::string> filter_warnings(const Spec& spec) {
  std::vector<std::string> warnings;
  for (const NamedFilter& f : spec.filters) {
    const int d = f.filter.derivative;
    if (d == 0) continue;
    const std::string said = "filter '" + f.name + "' is said to estimate derivative " + std::to_string(d);
    if (std::abs(f.norms.dc_gain) > 1e-9 * f.norms.h2)
      warnings.push_back(said + " and passes constants: H(1) = " + significant(f.norms.dc_gain, 4));
    else if (!estimates_its_derivative(f.filter))
      warnings.push_back(said + (low_frequency_gain(f.filter) > 1
                                     ? " and passes a lower one: for slow motion its gain grows without bound"
                                     : ", and for slow motion gives " +
                                           significant(low_frequency_gain(f.filter), 4) +
                                           " of it: are its coefficients scaled by 1/T?"));
  }
  return warnings;
}

FilterReport filter_report(const Spec& spec, const FilterQuestions& q) {
  FilterReport report{spec.file, q, {}, {}};
  if (q.noise || !q.motions.empty()) report.noise = noise_report(spec, q.motions);
  report.sine_errors = sine_errors(spec, q.motions);
  for (const NamedFilter& named : spec.filters) {
    double highest = q.motion_band ? q.motion_band->second : 0;
    for (const double f : q.frequencies) highest = std::max(highest, f);
    for (const MotionQuestion& m : q.motions) highest = std::max(highest, m.frequency);
    if (highest > 0.5 * named.filter.sample_rate)
      throw Error({{"", 0, 0},
                   "",
                   "a frequency lies above half the sample rate of filter '" + named.name + "'",
                   shortest(highest) + " Hz at " + shortest(named.filter.sample_rate) + " Hz",
                   ""},
                  Trouble::usage);
    report.filters.push_back(figures_of(named, q));
  }
  if (q.estimators) report.estimators = estimator_report(spec, q.clock);
  return report;
}

std::string write(const FilterReport& report, std::string_view format, const Style&) {
  const auto& estimators = report.estimators;
  if (format == "table")
    return filter_table(report) + noise_table(report.noise, report.sine_errors) +
           (estimators ? estimator_table(*estimators) : "");
  if (format == "csv")
    return estimators                         ? estimator_csv(*estimators)
           : report.questions.motions.empty() ? filter_csv(report)
                                              : noise_csv(report.noise);
  Json list = Json::array();
  for (std::size_t i = 0; i < report.filters.size(); ++i) {
    list.push_back(to_json(report.filters[i], report.questions.coefficients));
    if (i < report.noise.size()) add_noise(list.back(), report.noise[i]);
  }
  Json all = {
      {"qerr", version()}, {"command", "filter"}, {"spec", {{"file", report.file}}}, {"filters", list}};
  if (!report.sine_errors.empty()) all["quantized_sine"] = sine_error_json(report.sine_errors);
  if (estimators) all["estimators"] = estimator_json(*estimators);
  return all.dump(2) + "\n";
}

}  // namespace qerr
