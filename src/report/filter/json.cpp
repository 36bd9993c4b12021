#include "report/formats.hpp"
#include "report/json_header.hpp"
#include "report/json_value.hpp"

namespace qerr {

namespace {

Json filter_json(const FilterFigures& f, bool coefficients) {
  Json j = {{"name", f.name},
            {"derivative", f.filter.derivative},
            {"sample_rate", f.filter.sample_rate},
            {"h2_norm", f.norms.h2},
            {"h2_error", f.norms.h2_error},
            {"l1_norm", {{"lower", f.norms.l1.lower}, {"upper", f.norms.l1.upper}}},
            {"dc_gain", f.norms.dc_gain},
            {"group_delay_s", f.group_delay},
            {"poles_max_modulus", f.poles_max_modulus},
            {"bandwidth_hz", f.bandwidth},
            {"noise_bandwidth_hz", f.noise_bandwidth},
            {"settling_time_s", f.settling_time}};
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

void add_noise(Json& filter, const FilterNoise& f) {
  filter["ipqn_within_10_percent_above"] = f.within_10_percent;
  filter["ipqn_within_1_percent_above"] = f.within_1_percent;
  filter["noise_rise_time_s"] = f.rise_time;
  for (const NoiseRow& r : f.rows) {
    Json row = {{"encoder", r.encoder}, {"motion", r.motion.sine ? "sine" : "constant_speed"}};
    const std::string size = r.motion.sine ? "amplitude" : "speed";
    row[size] = r.motion.size;
    row[size + "_unit"] = r.motion.unit();
    if (r.motion.sine) row["frequency_hz"] = r.motion.frequency;
    row["counts_per_sample"] = r.counts_per_sample;
    row["sigma"] = r.sigma;
    row["sigma_ipqn"] = r.sigma_ipqn;
    row["sigma_unit"] = r.unit;
    filter["in_motion"].push_back(row);
  }
}

Json sine_error_json(const std::vector<SineErrorRow>& rows) {
  Json list = Json::array();
  for (const SineErrorRow& r : rows)
    list.push_back({{"encoder", r.encoder},
                    {"amplitude_counts", r.amplitude},
                    {"largest_mean_counts", r.largest_mean},
                    {"mean_envelope_counts", r.mean_envelope},
                    {"mean_square_counts2", {{"least", r.least_square}, {"largest", r.largest_square}}},
                    {"mean_square_envelope_counts2",
                     {{"least", 1.0 / 12 + r.square_below}, {"largest", 1.0 / 12 + r.square_above}}}});
  return list;
}

Json error_json(const EstimatorError& e, double speed) {
  Json j;
  for (const auto& [name, error] :
       {std::pair{"printed", e.printed}, {"varying", e.varying}, {"constant", e.constant}})
    j[name] = {{"error", error}, {"snr_db", worst_case_snr_db(speed, error)}};
  return j;
}

Json estimator_json(const EstimatorReport& report) {
  Json list = Json::array();
  for (const EncoderEstimators& e : report.encoders) {
    Json rows = Json::array();
    for (const EstimatorRow& r : e.rows)
      rows.push_back({{"speed", r.speed},
                      {"quanta_per_sample", r.quanta_per_sample},
                      {"finite_difference", error_json(r.finite_difference, r.speed)},
                      {"inverse_time", error_json(r.inverse_time, r.speed)},
                      {"better", r.inverse_time_is_better() ? "inverse_time" : "finite_difference"}});
    list.push_back({{"encoder", e.encoder},
                    {"unit", e.unit},
                    {"resolution", e.resolution},
                    {"sample_rate", report.sample_rate},
                    {"clock", report.clock},
                    {"crossing_speed", e.crossing_speed},
                    {"edge_distance", {{"shortest", e.edges.shortest}, {"longest", e.edges.longest}}},
                    {"speeds", rows}});
  }
  return list;
}

}  // namespace

Json report_json(const FilterReport& report) {
  Json list = Json::array();
  for (std::size_t i = 0; i < report.filters.size(); ++i) {
    list.push_back(filter_json(report.filters[i], report.questions.coefficients));
    if (i < report.noise.size()) add_noise(list.back(), report.noise[i]);
  }
  Json all = {
      {"qerr", version()}, {"command", "filter"}, {"spec", spec_source(report.spec)}, {"filters", list}};
  if (!report.sine_errors.empty()) all["quantized_sine"] = sine_error_json(report.sine_errors);
  if (report.estimators) all["estimators"] = estimator_json(*report.estimators);
  return all;
}

std::string to_json(const FilterReport& report, const Style&) { return report_json(report).document(); }

}  // namespace qerr
