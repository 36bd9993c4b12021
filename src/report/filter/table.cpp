#include "report/filter/tables.hpp"
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

std::string fidelity_table(const FilterFigures& f) {
  if (f.fidelity.empty()) return {};
  std::vector<std::vector<std::string>> at{{"frequency", "gain error", "phase error", "tracking error"}};
  for (const Fidelity& x : f.fidelity)
    at.push_back({readable(x.frequency, "Hz"), percent(x.gain_error), readable(x.phase_error, "rad"),
                  percent(x.tracking_error)});
  return title(f) + "compared with the ideal derivative\n" + aligned(at);
}

std::string tracking_line(const FilterFigures& f, const FilterQuestions& q) {
  if (!f.tracking) return {};
  return title(f) + "tracking error for motion from " + readable(q.motion_band->first, "Hz") + " to " +
         readable(q.motion_band->second, "Hz") + ": " + percent(f.tracking->largest) + " at most, " +
         percent(f.tracking->rms) + " rms\n";
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
    for (std::size_t i = 0; i < s.size(); ++i) out += (i == 3 ? "  /  " : "  ") + shortest(s[i]);
    out += '\n';
  }
  return out;
}

/// A modulus near 1 is written as its distance from 1, which determines the time constant.
std::string modulus_of(double modulus) {
  return modulus > 0.999 && modulus < 1 ? "1 - " + significant(1 - modulus, 3) : significant(modulus, 6);
}

std::string norm_table(const FilterReport& report) {
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
  return aligned(rows);
}

std::string dynamics_table(const FilterReport& report) {
  const auto figure = [](const std::optional<double>& value, const char* unit) {
    return value ? readable(*value, unit) : "none";
  };
  std::vector<std::vector<std::string>> rows{
      {"filter", "delay", "settling (2 %)", "-3 dB", "noise-equivalent bandwidth"}};
  for (const FilterFigures& f : report.filters)
    rows.push_back({escaped(f.name, 40), readable(f.group_delay, "s"), figure(f.settling_time, "s"),
                    figure(f.bandwidth, "Hz"), figure(f.noise_bandwidth, "Hz")});
  return aligned(rows);
}

std::string filter_table(const FilterReport& report) {
  std::string out = norm_table(report) + '\n' + dynamics_table(report);
  for (const FilterFigures& f : report.filters) {
    out += fidelity_table(f) + tracking_line(f, report.questions);
    if (report.questions.coefficients) out += coefficient_table(f);
  }
  return out;
}

}  // namespace

std::string to_table(const FilterReport& report, const Style&) {
  return filter_table(report) + noise_table(report) +
         (report.estimators ? estimator_table(*report.estimators) : "");
}

}  // namespace qerr
