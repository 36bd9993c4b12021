
#include <cmath>
#include <string>

#include "qerr/report/filter_report.hpp"
#include "report/analysis/tables.hpp"
#include "report/formats.hpp"
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

}  // namespace

std::string to_table(const FilterReport& report, const Style& style) {
  return filter_table(report, style.width) + noise_table(report, style.width) +
         (report.estimators ? estimator_table(*report.estimators, style.width) : "");
}

}  // namespace qerr
