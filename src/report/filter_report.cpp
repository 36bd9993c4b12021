#include "qerr/report/filter_report.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "estimator_json.hpp"
#include "noise_json.hpp"
#include "qerr/report/write.hpp"
#include "text_table.hpp"

namespace qerr {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t most_impulse_samples = 100000;

FilterFigures figures_of(const NamedFilter& named, const FilterQuestions& q) {
  const Filter& filter = named.filter;
  FilterFigures f{named.name,
                  filter,
                  named.norms,
                  group_delay(filter),
                  poles_max_modulus(filter),
                  bandwidth(filter),
                  noise_bandwidth(filter, named.norms.h2),
                  settling_time(filter),
                  {},
                  {}};
  for (const double frequency : q.frequencies) f.fidelity.push_back(fidelity(filter, frequency));
  if (q.motion_band) f.tracking = band_tracking(filter, q.motion_band->first, q.motion_band->second);
  return f;
}

Json or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

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
            {"bandwidth_hz", or_null(f.bandwidth)},
            {"noise_bandwidth_hz", f.noise_bandwidth},
            {"settling_time_s", or_null(f.settling_time)}};
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

std::string percent(double value) { return shortest_of(100 * value, 3) + " %"; }

/// The upper end, and the lower one where they can be told apart.
std::string l1_of(const Interval& l1) {
  const std::string upper = shortest_of(l1.upper, 6);
  return l1.upper - l1.lower > 1e-6 * l1.upper ? shortest_of(l1.lower, 3) + ".." + upper : upper;
}

std::string table(const FilterReport& report, const Style&) {
  std::vector<std::vector<std::string>> rows{{"filter", "H2 norm", "l1 norm", "H(1)", "delay", "-3 dB",
                                              "noise band", "settles (2 %)", "largest pole"}};
  for (const FilterFigures& f : report.filters) {
    const int d = f.filter.derivative;
    const std::string unit = d == 0 ? "" : d == 1 ? "/s" : "/s^" + std::to_string(d);
    // Only coefficients that hardly determine their filter leave more than rounding.
    const bool doubtful = f.norms.h2_error > 1e-12 * f.norms.h2;
    rows.push_back(
        {escaped(f.name, 40),
         shortest_of(f.norms.h2, 6) + (doubtful ? " +- " + shortest_of(f.norms.h2_error, 2) : "") + unit,
         l1_of(f.norms.l1) + unit, shortest_of(f.norms.dc_gain, 4), readable(f.group_delay, "s"),
         f.bandwidth ? readable(*f.bandwidth, "Hz") : "none", readable(f.noise_bandwidth, "Hz"),
         f.settling_time ? readable(*f.settling_time, "s") : "does not",
         shortest_of(f.poles_max_modulus, 6)});
  }
  std::string out = aligned(rows);
  for (const FilterFigures& f : report.filters) {
    if (!f.fidelity.empty()) {
      out += "\n" + escaped(f.name, 40) + ": against the ideal derivative\n";
      std::vector<std::vector<std::string>> at{{"frequency", "gain error", "phase error", "tracking error"}};
      for (const Fidelity& x : f.fidelity)
        at.push_back({readable(x.frequency, "Hz"), percent(x.gain_error), readable(x.phase_error, "rad"),
                      percent(x.tracking_error)});
      out += aligned(at);
    }
    if (f.tracking)
      out += "\n" + escaped(f.name, 40) + ": tracking error for motion from " +
             readable(report.questions.motion_band->first, "Hz") + " to " +
             readable(report.questions.motion_band->second, "Hz") + ": " + percent(f.tracking->largest) +
             " at most, " + percent(f.tracking->rms) + " rms\n";
    if (!report.questions.coefficients) continue;
    out += "\n" + escaped(f.name, 40) + ": sections b0 b1 b2 / 1 a1 a2 in ascending powers of z^-1\n";
    if (!f.filter.taps.empty()) {
      for (const double tap : impulse_response(f.filter, f.filter.taps.size()))
        out += "  " + shortest(tap) + "\n";
      continue;
    }
    for (const auto& s : second_order_sections(f.filter)) {
      for (std::size_t i = 0; i < s.size(); ++i) out += (i == 3 ? "  /  " : "  ") + shortest(s[i]);
      out += '\n';
    }
  }
  return out;
}

std::string csv(const FilterReport& report) {
  std::string out = "filter,quantity,unit,value\r\n";
  for (const FilterFigures& f : report.filters) {
    const std::string d = f.filter.derivative == 0 ? "" : "1/s^" + std::to_string(f.filter.derivative);
    const auto row = [&](const std::string& quantity, const std::string& unit,
                         const std::optional<double>& value) {
      out += csv_cell(f.name) + ',' + quantity + ',' + unit + ',' + (value ? shortest(*value) : "") + "\r\n";
    };
    row("h2_norm", d, f.norms.h2);
    row("h2_error", d, f.norms.h2_error);
    row("l1_norm.lower", d, f.norms.l1.lower);
    row("l1_norm.upper", d, f.norms.l1.upper);
    row("dc_gain", d, f.norms.dc_gain);
    row("group_delay", "s", f.group_delay);
    row("poles_max_modulus", "", f.poles_max_modulus);
    row("bandwidth", "Hz", f.bandwidth);
    row("noise_bandwidth", "Hz", f.noise_bandwidth);
    row("settling_time", "s", f.settling_time);
  }
  for (const FilterNoise& f : report.noise) {
    const auto row = [&](const char* quantity, const char* unit, const std::optional<double>& value) {
      out +=
          csv_cell(f.filter) + ',' + quantity + ',' + unit + ',' + (value ? shortest(*value) : "") + "\r\n";
    };
    row("ipqn_within_10_percent_above", "counts/sample", f.within_10_percent);
    row("ipqn_within_1_percent_above", "counts/sample", f.within_1_percent);
    row("noise_rise_time", "s", f.rise_time);
  }
  return out;
}

}  // namespace

FilterReport filter_report(const Spec& spec, const FilterQuestions& q) {
  FilterReport report{spec.file, q, {}, {}};
  if (q.noise || !q.motions.empty()) report.noise = noise_report(spec, q.motions);
  for (const NamedFilter& named : spec.filters) {
    double highest = q.motion_band ? q.motion_band->second : 0;
    for (const double f : q.frequencies) highest = std::max(highest, f);
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

std::string write(const FilterReport& report, std::string_view format, const Style& style) {
  const auto& estimators = report.estimators;
  if (format == "table")
    return table(report, style) + noise_table(report.noise) +
           (estimators ? estimator_table(*estimators) : "");
  if (format == "csv")
    return estimators                         ? estimator_csv(*estimators)
           : report.questions.motions.empty() ? csv(report)
                                              : noise_csv(report.noise);
  Json list = Json::array();
  for (std::size_t i = 0; i < report.filters.size(); ++i) {
    list.push_back(to_json(report.filters[i], report.questions.coefficients));
    if (i < report.noise.size()) add_noise(list.back(), report.noise[i]);
  }
  Json all = {
      {"qerr", version()}, {"command", "filter"}, {"spec", {{"file", report.file}}}, {"filters", list}};
  if (estimators) all["estimators"] = estimator_json(*estimators);
  return all.dump(2) + "\n";
}

std::string response_csv(const FilterReport& report) {
  constexpr int points = 500;
  std::string out = "filter,frequency [Hz],magnitude,phase [rad]\r\n";
  for (const FilterFigures& f : report.filters)
    for (int i = 0; i <= points; ++i) {
      const double frequency =
          f.filter.sample_rate * (i == points ? 0.5 : 1e-5 * std::pow(5e4, static_cast<double>(i) / points));
      const std::complex<double> h = response(f.filter, frequency);
      out += csv_cell(f.name) + ',' + shortest(frequency) + ',' + shortest(std::abs(h)) + ',' +
             shortest(std::arg(h)) + "\r\n";
    }
  return out;
}

std::string impulse_csv(const FilterReport& report) {
  std::string out = "filter,time [s],value\r\n";
  for (const FilterFigures& f : report.filters) {
    const double decay =
        f.poles_max_modulus < 1 ? -30 / std::log(std::max(f.poles_max_modulus, 1e-3)) : INFINITY;
    const double wanted = 16 + static_cast<double>(f.filter.taps.size()) + decay;
    const auto samples =
        static_cast<std::size_t>(std::min(wanted, static_cast<double>(most_impulse_samples)));
    const std::vector<double> h = impulse_response(f.filter, samples);
    for (std::size_t k = 0; k < h.size(); ++k)
      out += csv_cell(f.name) + ',' + shortest(static_cast<double>(k) / f.filter.sample_rate) + ',' +
             shortest(h[k]) + "\r\n";
  }
  return out;
}

}  // namespace qerr
