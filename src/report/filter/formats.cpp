#include "report/formats.hpp"

#include <cmath>

#include "report/analysis/tables.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

/// The upper bound, and the lower one if they differ by more than the digits shown.
std::string l1_of(const Interval& l1) {
  if (l1.upper < 1e-200) return "0";
  const std::string upper = significant(l1.upper, 6);
  return l1.upper - l1.lower > 1e-6 * l1.upper ? significant(l1.lower, 3) + ".." + upper : upper;
}

std::string title(const FilterFigures& f) { return "\n" + escaped(f.name, 40) + ": "; }

std::string fidelity_table(const FilterReport& report, std::size_t width) {
  if (report.questions.frequencies.empty()) return {};
  TableRows rows{{"filter", "frequency", "gain error", "phase error", "tracking error"}};
  for (const FilterFigures& f : report.filters)
    for (const Fidelity& x : f.fidelity)
      rows.push_back({&x == &f.fidelity.front() ? escaped(f.name, 40) : "", readable(x.frequency, "Hz"),
                      percent(x.gain_error), readable(x.phase_error, "rad"), percent(x.tracking_error)});
  return "\nCompared with the ideal derivative\n" + fitted_table(rows, width);
}

std::string coefficient_table(const FilterFigures& f) {
  std::string out = title(f);
  if (!f.filter.taps.empty()) {
    out += "taps h_0, h_1, ... of z^0, z^-1, ...\n";
    for (const double tap : impulse_response(f.filter, f.filter.taps.size()))
      out += "  " + shortest(tap) + "\n";
    return out;
  }
  out += "sections b0 b1 b2 / 1 a1 a2 in ascending powers of z^-1\n";
  for (const auto& s : second_order_sections(f.filter)) {
    for (std::size_t i = 0; i < s.size(); ++i) out += (i == 3 ? "\n    /  " : "  ") + shortest(s[i]);
    out += '\n';
  }
  return out;
}

/// A modulus near 1 is written as its distance from 1, which determines the time constant.
std::string modulus_of(double modulus) {
  return modulus > 0.999 && modulus < 1 ? "1 - " + significant(1 - modulus, 3) : significant(modulus, 6);
}

std::string norm_table(const FilterReport& report, std::size_t width) {
  TableRows rows{{"filter", "H2 norm", "l1 norm", "H(1)", "largest pole"}};
  for (const FilterFigures& f : report.filters) {
    const std::string unit = f.filter.derivative == 0 ? "" : rate_unit(f.filter.derivative).substr(1);
    // Ill-conditioned coefficients: the error exceeds rounding.
    const bool ill_conditioned = f.norms.h2 > 0 && f.norms.h2_error > 1e-12 * f.norms.h2;
    rows.push_back({escaped(f.name, 40),
                    significant(f.norms.h2, 6) +
                        (ill_conditioned ? " +- " + significant(f.norms.h2_error, 2) : "") + unit,
                    l1_of(f.norms.l1) + unit, significant(f.norms.dc_gain, 4),
                    modulus_of(f.poles_max_modulus)});
  }
  return fitted_table(rows, width);
}

using ReportedFilter = In<FilterFigures, FilterReport>;
using ComparedEncoder = In<EncoderEstimators, EstimatorReport>;

/// A figure of the filter's noise: empty unless it was asked for.
template <class T>
auto noise(T FilterNoise::*value) {
  return [value](const ReportedFilter& f) {
    const auto& noise = f.whole.noise;
    return f.i < noise.size() ? std::optional<T>(noise[f.i].*value) : std::nullopt;
  };
}

std::string dynamics_table(const FilterReport& report, std::size_t width) {
  const auto figure = [](const std::optional<double>& value, const char* unit) {
    return value ? readable(*value, unit) : "none";
  };
  TableRows rows{{"filter", "delay", "settling to 2 %", "-3 dB", "equivalent noise bandwidth"}};
  const auto& band = report.questions.motion_band;
  if (band) rows.front().insert(rows.front().end(), {"tracking error", "its rms"});
  for (const FilterFigures& f : report.filters) {
    rows.push_back({escaped(f.name, 40), readable(f.group_delay, "s"), figure(f.settling_time, "s"),
                    figure(f.bandwidth, "Hz"), figure(f.noise_bandwidth, "Hz")});
    if (f.tracking)
      rows.back().insert(rows.back().end(), {percent(f.tracking->largest), percent(f.tracking->rms)});
  }
  const std::string note =
      band ? wrapped("tracking error: at most, and rms, for motion from " + readable(band->first, "Hz") +
                         " to " + readable(band->second, "Hz"),
                     width, "  ")
           : "";
  return fitted_table(rows, width) + note;
}

std::string filter_table(const FilterReport& report, std::size_t width) {
  std::string out =
      norm_table(report, width) + '\n' + dynamics_table(report, width) + fidelity_table(report, width);
  if (report.questions.coefficients)
    for (const FilterFigures& f : report.filters) out += coefficient_table(f);
  return out;
}

std::string text_of(const MotionQuestion& m) {
  return significant(m.size, 6) + ' ' + m.unit() + (m.sine ? " at " + readable(m.frequency, "Hz") : "");
}

std::string threshold_text(const std::optional<double>& threshold) {
  return threshold ? significant(*threshold, 3) : "not searched";
}

std::string sine_table(const std::vector<SineErrorRow>& rows, std::size_t width) {
  if (rows.empty()) return {};
  TableRows cells{{"encoder", "amplitude", "|mean| up to", "envelope", "mean square / IPQN", "envelope"}};
  for (const SineErrorRow& r : rows)
    cells.push_back(
        {escaped(r.encoder, 40), significant(r.amplitude, 5), significant(r.largest_mean, 3),
         significant(r.mean_envelope, 3),
         significant(12 * r.least_square, 5) + ".." + significant(12 * r.largest_square, 5),
         significant(1 + 12 * r.square_below, 5) + ".." + significant(1 + 12 * r.square_above, 5)});
  return "\nError of the quantizer along the sine, in counts, over all zeros of the encoder;\n"
         "envelopes of the paper (Appendix B)\n" +
         fitted_table(cells, width);
}

/// The accuracy of IPQN behind every filter, and the noise in motion; "" if the report has neither.
std::string noise_table(const FilterReport& report, std::size_t width) {
  if (report.noise.empty()) return {};
  TableRows rows{{"filter", "within 10 % above", "within 1 % above", "99 % of the noise after"}};
  for (const FilterNoise& f : report.noise)
    rows.push_back({escaped(f.filter, 40),
                    f.followed ? threshold_text(f.within_10_percent) : "memory too long",
                    f.followed ? threshold_text(f.within_1_percent) : "",
                    f.rise_time ? readable(*f.rise_time, "s") : ""});
  std::string out = "\nPeak speeds of slow sines, in counts per sample, above which IPQN is accurate\n" +
                    fitted_table(rows, width);
  for (const FilterNoise& f : report.noise) {
    if (f.rows.empty()) continue;
    TableRows cells{{"encoder", "motion", "counts per sample", "sigma", "IPQN", "ratio"}};
    for (const NoiseRow& row : f.rows)
      cells.push_back({escaped(row.encoder, 40), text_of(row.motion), significant(row.counts_per_sample, 4),
                       row.sigma ? readable(*row.sigma, row.unit) : "not known",
                       readable(row.sigma_ipqn, row.unit),
                       row.sigma && row.sigma_ipqn > 0 ? significant(*row.sigma / row.sigma_ipqn, 4) : ""});
    out += "\n" + escaped(f.filter, 40) + ": sigma of the filtered error of an encoder in motion\n" +
           fitted_table(cells, width);
  }
  return out + sine_table(report.sine_errors, width);
}

std::string decibels(double speed, double error) {
  if (!std::isfinite(error)) return "-";
  return std::to_string(std::lround(worst_case_snr_db(speed, error))) + " dB";
}

bool same_encoder(const EncoderEstimators& a, const EncoderEstimators& b) {
  return a.resolution == b.resolution && a.unit == b.unit && a.edges == b.edges;
}

std::string error_text(double error, const std::string& unit) { return readable(error, unit); }

RowsOf<EstimatorRow> bound(EstimatorError EstimatorRow::*errors, double EstimatorError::*bound) {
  return {{"error", [=](auto& r) { return r.*errors.*bound; }, nullable},
          {"snr_db", [=](auto& r) { return worst_case_snr_db(r.speed, r.*errors.*bound); }, nullable}};
}

std::string estimator_table(const EstimatorReport& report, std::size_t width) {
  std::string out = "\nVelocity from counts, worst case: finite differences (FDM) at " +
                    readable(report.sample_rate, "Hz") + ",\ntime between edges (ITM) with a clock of " +
                    readable(report.clock, "Hz") + "\n";
  for (std::size_t i = 0; i < report.encoders.size(); ++i) {
    const EncoderEstimators& e = report.encoders[i];
    std::string names = escaped(e.encoder, 40);
    for (; i + 1 < report.encoders.size() && same_encoder(e, report.encoders[i + 1]); ++i)
      names += ", " + escaped(report.encoders[i + 1].encoder, 40);
    out += "\n" + wrapped(names + ": ITM is at least as good up to " + readable(e.crossing_speed, e.unit) +
                              (e.edges.ideal() ? ""
                                               : "; with the effects of the disc, whose edges are " +
                                                     significant(e.edges.shortest, 3) + " to " +
                                                     significant(e.edges.longest, 3) + " counts apart"),
                          width);
    TableRows rows{
        {"speed", "counts per sample", "FDM error", "SNR", "ITM error", "SNR", "SNR as printed", "better"}};
    for (const EstimatorRow& r : e.rows) {
      const EstimatorError &fdm = r.finite_difference, &itm = r.inverse_time;
      rows.push_back({readable(r.speed, e.unit), significant(r.quanta_per_sample, 3),
                      error_text(fdm.varying, e.unit), decibels(r.speed, fdm.varying),
                      error_text(itm.varying, e.unit), decibels(r.speed, itm.varying),
                      decibels(r.speed, itm.printed), r.inverse_time_is_better() ? "ITM" : "FDM"});
    }
    out += fitted_table(rows, width);
  }
  return out + "\n" +
         wrapped(
             "ITM: for a speed that rises or falls up to the one shown between two edges; unbounded: two "
             "edges may "
             "fall into one tick. The paper's bound (52), as printed, is valid and loose.",
             width);
}

RowsOf<EstimatorRow> bounds(EstimatorError EstimatorRow::*errors) {
  return {{"printed", bound(errors, &EstimatorError::printed), "the paper's bound, as printed"},
          {"varying", bound(errors, &EstimatorError::varying), "for a speed that varies between two edges"},
          {"constant", bound(errors, &EstimatorError::constant)}};
}

std::string filter_csv(const FilterReport& report) {
  std::string out = "filter,quantity,unit,value\r\n";
  const auto row_of = [&out](const std::string& filter) {
    return [&out, name = csv_cell(filter)](const std::string& quantity, const std::string& unit,
                                           const std::optional<double>& value) {
      out += name + ',' + quantity + ',' + unit + ',' + csv_number(value) + "\r\n";
    };
  };
  for (const FilterFigures& f : report.filters) {
    const std::string d = rate_unit(f.filter.derivative);
    const auto row = row_of(f.name);
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
    const auto row = row_of(f.filter);
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

std::string to_table(const FilterReport& report, const Style& style) {
  return filter_table(report, style.width) + noise_table(report, style.width) +
         (report.estimators ? estimator_table(*report.estimators, style.width) : "");
}

RowsOf<Fidelity> rows(Of<Fidelity>) {
  return {{"frequency", &Fidelity::frequency},
          {"gain_error", &Fidelity::gain_error, nullable},
          {"phase_error", &Fidelity::phase_error, nullable},
          {"tracking_error", &Fidelity::tracking_error, nullable}};
}

RowsOf<BandTracking> rows(Of<BandTracking>) {
  return {{"largest", &BandTracking::largest}, {"rms", &BandTracking::rms}};
}

RowsOf<NoiseRow> rows(Of<NoiseRow>) {
  return {{"encoder", &NoiseRow::encoder},
          {"motion", [](auto& r) { return r.motion.sine ? "sine" : "constant_speed"; },
           one_of({"sine", "constant_speed"})},
          {"speed", [](auto& r) { return only_if(!r.motion.sine, r.motion.size); }, "of a constant speed",
           optional},
          {"speed_unit", [](auto& r) { return only_if(!r.motion.sine, r.motion.unit()); }, optional},
          {"amplitude", [](auto& r) { return only_if(r.motion.sine, r.motion.size); }, "of a sine", optional},
          {"amplitude_unit", [](auto& r) { return only_if(r.motion.sine, r.motion.unit()); }, optional},
          {"frequency_hz", [](auto& r) { return only_if(r.motion.sine, r.motion.frequency); }, "of a sine",
           optional},
          {"counts_per_sample", &NoiseRow::counts_per_sample},
          {"sigma", &NoiseRow::sigma, "null: the filter's memory is too long"},
          {"sigma_ipqn", &NoiseRow::sigma_ipqn},
          {"sigma_unit", &NoiseRow::unit}};
}

RowsOf<ReportedFilter> rows(Of<ReportedFilter>) {
  using Figures = FilterFigures;
  return {
      {"name", &Figures::name},
      {"derivative", [](auto& f) { return f->filter.derivative; }},
      {"sample_rate", [](auto& f) { return f->filter.sample_rate; }},
      {"h2_norm", [](auto& f) { return f->norms.h2; }},
      {"h2_error", [](auto& f) { return f->norms.h2_error; }, "bound of its numerical error"},
      {"l1_norm", [](auto& f) { return f->norms.l1; }},
      {"dc_gain", [](auto& f) { return f->norms.dc_gain; }, "H(1)", nullable},
      {"group_delay_s", &Figures::group_delay, "limit at 0 Hz", nullable},
      {"poles_max_modulus", &Figures::poles_max_modulus},
      {"bandwidth_hz", &Figures::bandwidth, "-3 dB"},
      {"noise_bandwidth_hz", &Figures::noise_bandwidth},
      {"settling_time_s", &Figures::settling_time, "to 2 %"},
      {"at", &Figures::fidelity, "with --at", optional},
      {"motion_band", &Figures::tracking, "tracking error, with --motion-band", optional},
      {"sections",
       [](auto& f) {
         return f.whole.questions.coefficients && f->filter.taps.empty()
                    ? std::optional(second_order_sections(f->filter))
                    : std::nullopt;
       },
       "with --coefficients", optional},
      {"taps",
       [](auto& f) {
         return impulse_response(f->filter, f.whole.questions.coefficients ? f->filter.taps.size() : 0);
       },
       "with --coefficients", optional},
      {"ipqn_within_10_percent_above", noise(&FilterNoise::within_10_percent), "counts per sample", optional},
      {"ipqn_within_1_percent_above", noise(&FilterNoise::within_1_percent), "counts per sample", optional},
      {"noise_rise_time_s", noise(&FilterNoise::rise_time), optional},
      {"in_motion", noise(&FilterNoise::rows), "with --speed or --sine", optional}};
}

RowsOf<SineErrorRow> rows(Of<SineErrorRow>) {
  using Sine = SineErrorRow;
  return {{"encoder", &Sine::encoder},
          {"amplitude_counts", &Sine::amplitude},
          {"largest_mean_counts", &Sine::largest_mean},
          {"mean_envelope_counts", &Sine::mean_envelope},
          {"mean_square_counts2", {{"least", &Sine::least_square}, {"largest", &Sine::largest_square}}},
          {"mean_square_envelope_counts2",
           {{"least", [](auto& r) { return 1.0 / 12 + r.square_below; }},
            {"largest", [](auto& r) { return 1.0 / 12 + r.square_above; }}}}};
}

RowsOf<EstimatorRow> rows(Of<EstimatorRow>) {
  return {
      {"speed", &EstimatorRow::speed},
      {"quanta_per_sample", &EstimatorRow::quanta_per_sample},
      {"finite_difference", bounds(&EstimatorRow::finite_difference)},
      {"inverse_time", bounds(&EstimatorRow::inverse_time)},
      {"better", [](auto& r) { return r.inverse_time_is_better() ? "inverse_time" : "finite_difference"; },
       one_of({"finite_difference", "inverse_time"})}};
}

RowsOf<ComparedEncoder> rows(Of<ComparedEncoder>) {
  using Estimators = EncoderEstimators;
  return {{"encoder", &Estimators::encoder},
          {"unit", &Estimators::unit},
          {"resolution", &Estimators::resolution},
          {"sample_rate", [](auto& e) { return e.whole.sample_rate; }},
          {"clock", [](auto& e) { return e.whole.clock; }},
          {"crossing_speed", &Estimators::crossing_speed, nullable},
          {"edge_distance",
           {{"shortest", [](auto& e) { return e->edges.shortest; }},
            {"longest", [](auto& e) { return e->edges.longest; }, nullable}},
           "of neighbouring edges, with the effects of the disc [counts]"},
          {"speeds", &Estimators::rows}};
}

RowsOf<FilterReport> rows(Of<FilterReport>) {
  return header<FilterReport>("filter").with(
      {{"spec", &FilterReport::spec},
       {"filters", within(&FilterReport::filters)},
       {"quantized_sine", &FilterReport::sine_errors, "with --sine", optional},
       {"estimators",
        [](auto& r) {
          const auto encoders = within(&EstimatorReport::encoders);
          return r.estimators ? std::optional(encoders(*r.estimators)) : std::nullopt;
        },
        "with --estimators", optional}});
}

/// One file holds one table: of the estimators, else of the motions, else of the filters.
std::string to_csv(const FilterReport& report, const Style&) {
  if (report.estimators) return estimator_csv(*report.estimators);
  return report.questions.motions.empty() ? filter_csv(report) : noise_csv(report.noise);
}

}  // namespace qerr
