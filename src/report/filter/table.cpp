#include "report/filter/tables.hpp"
#include "report/fitted_table.hpp"
#include "report/formats.hpp"
#include "report/text_table.hpp"
#include "report/wrapped_text.hpp"

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
  std::vector<std::vector<std::string>> rows{
      {"filter", "frequency", "gain error", "phase error", "tracking error"}};
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
  std::vector<std::vector<std::string>> rows{{"filter", "H2 norm", "l1 norm", "H(1)", "largest pole"}};
  for (const FilterFigures& f : report.filters) {
    const int d = f.filter.derivative;
    const std::string unit = d == 0 ? "" : d == 1 ? "/s" : "/s^" + std::to_string(d);
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
  std::vector<std::vector<std::string>> rows{
      {"filter", "delay", "settling to 2 %", "-3 dB", "equivalent noise bandwidth"}};
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

}  // namespace

std::string to_table(const FilterReport& report, const Style& style) {
  return filter_table(report, style.width) + noise_table(report, style.width) +
         (report.estimators ? estimator_table(*report.estimators, style.width) : "");
}

}  // namespace qerr
