#include "report/csv_text.hpp"
#include "report/formats.hpp"

namespace qerr {

namespace {

/// `filter,quantity,unit,value`.
std::string filter_csv(const FilterReport& report) {
  std::string out = "filter,quantity,unit,value\r\n";
  for (const FilterFigures& f : report.filters) {
    const int order = f.filter.derivative;
    const std::string d = order == 0 ? "" : order == 1 ? "1/s" : "1/s^" + std::to_string(order);
    const auto row = [&](const std::string& quantity, const std::string& unit,
                         const std::optional<double>& value) {
      out += csv_cell(f.name) + ',' + quantity + ',' + unit + ',' + csv_number(value) + "\r\n";
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
    for (const Fidelity& x : f.fidelity) {
      const std::string at = " at " + shortest(x.frequency) + " Hz";
      row("gain_error" + at, "1", x.gain_error);
      row("phase_error" + at, "rad", x.phase_error);
      row("tracking_error" + at, "1", x.tracking_error);
    }
    if (f.tracking) {
      row("motion_band.largest", "1", f.tracking->largest);
      row("motion_band.rms", "1", f.tracking->rms);
    }
    if (!report.questions.coefficients) continue;
    std::size_t tap = 0, section = 0;
    if (!f.filter.taps.empty()) {
      for (const double h : impulse_response(f.filter, f.filter.taps.size()))
        row("tap." + std::to_string(tap++), d, h);
      continue;
    }
    for (const auto& s : second_order_sections(f.filter)) {
      static constexpr const char* names[] = {"b0", "b1", "b2", "a0", "a1", "a2"};
      for (std::size_t c = 0; c < s.size(); ++c)
        row("section." + std::to_string(section) + '.' + names[c], "", s[c]);
      ++section;
    }
  }
  for (const FilterNoise& f : report.noise) {
    const auto row = [&](const char* quantity, const char* unit, const std::optional<double>& value) {
      out += csv_cell(f.filter) + ',' + quantity + ',' + unit + ',' + csv_number(value) + "\r\n";
    };
    row("ipqn_within_10_percent_above", "counts/sample", f.within_10_percent);
    row("ipqn_within_1_percent_above", "counts/sample", f.within_1_percent);
    row("noise_rise_time", "s", f.rise_time);
  }
  return out;
}

/// One row for each motion; sigma is empty if it is not known.
std::string noise_csv(const std::vector<FilterNoise>& noise) {
  std::string out =
      "filter,encoder,motion,size,size_unit,frequency [Hz],counts_per_sample,unit,sigma,sigma_ipqn\r\n";
  for (const FilterNoise& f : noise)
    for (const NoiseRow& r : f.rows)
      out += csv_cell(f.filter) + ',' + csv_cell(r.encoder) +
             (r.motion.sine ? ",sine," : ",constant_speed,") + shortest(r.motion.size) + ',' +
             r.motion.unit() + ',' + (r.motion.sine ? shortest(r.motion.frequency) : "") + ',' +
             shortest(r.counts_per_sample) + ',' + r.unit + ',' + csv_number(r.sigma) + ',' +
             shortest(r.sigma_ipqn) + "\r\n";
  return out;
}

/// One row for each bound; empty if it is infinite.
std::string estimator_csv(const EstimatorReport& report) {
  std::string out = "encoder,speed,unit,quanta_per_sample,estimator,bound,error,snr_db\r\n";
  for (const EncoderEstimators& e : report.encoders)
    for (const EstimatorRow& r : e.rows)
      for (const auto& [estimator, error] :
           {std::pair{"finite_difference", r.finite_difference}, {"inverse_time", r.inverse_time}})
        for (const auto& [bound, value] :
             {std::pair{"printed", error.printed}, {"varying", error.varying}, {"constant", error.constant}})
          out += csv_cell(e.encoder) + ',' + shortest(r.speed) + ',' + e.unit + ',' +
                 shortest(r.quanta_per_sample) + ',' + estimator + ',' + bound + ',' + csv_number(value) +
                 ',' + csv_number(worst_case_snr_db(r.speed, value)) + "\r\n";
  return out;
}

}  // namespace

/// One file holds one table: of the estimators, else of the motions, else of the filters.
std::string to_csv(const FilterReport& report, const Style&) {
  if (report.estimators) return estimator_csv(*report.estimators);
  return report.questions.motions.empty() ? filter_csv(report) : noise_csv(report.noise);
}

}  // namespace qerr
