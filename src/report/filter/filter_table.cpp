#include "core/text.hpp"
#include "qerr/report/write.hpp"
#include "report/filter/filter_writers.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

std::string percent(double value) { return significant(100 * value, 3) + " %"; }

/// The upper end, and the lower one where they can be told apart.
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
  return title(f) + "against the ideal derivative\n" + aligned(at);
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

/// A slow pole by its distance from 1.
std::string modulus_of(double modulus) {
  return modulus > 0.999 && modulus < 1 ? "1 - " + significant(1 - modulus, 3) : significant(modulus, 6);
}

}  // namespace

std::string filter_table(const FilterReport& report) {
  std::vector<std::vector<std::string>> rows{{"filter", "H2 norm", "l1 norm", "H(1)", "delay", "-3 dB",
                                              "noise band", "settles (2 %)", "largest pole"}};
  for (const FilterFigures& f : report.filters) {
    const int d = f.filter.derivative;
    const std::string unit = d == 0 ? "" : d == 1 ? "/s" : "/s^" + std::to_string(d);
    // Only coefficients that hardly determine their filter leave more than rounding.
    const bool doubtful = f.norms.h2 > 0 && f.norms.h2_error > 1e-12 * f.norms.h2;
    rows.push_back(
        {escaped(f.name, 40),
         significant(f.norms.h2, 6) + (doubtful ? " +- " + significant(f.norms.h2_error, 2) : "") + unit,
         l1_of(f.norms.l1) + unit, significant(f.norms.dc_gain, 4), readable(f.group_delay, "s"),
         f.bandwidth ? readable(*f.bandwidth, "Hz") : "none",
         f.noise_bandwidth ? readable(*f.noise_bandwidth, "Hz") : "none",
         f.settling_time ? readable(*f.settling_time, "s") : "does not", modulus_of(f.poles_max_modulus)});
  }
  std::string out = aligned(rows);
  for (const FilterFigures& f : report.filters) {
    out += fidelity_table(f) + tracking_line(f, report.questions);
    if (report.questions.coefficients) out += coefficient_table(f);
  }
  return out;
}

std::string filter_csv(const FilterReport& report) {
  std::string out = "filter,quantity,unit,value\r\n";
  for (const FilterFigures& f : report.filters) {
    const int order = f.filter.derivative;
    const std::string d = order == 0 ? "" : order == 1 ? "1/s" : "1/s^" + std::to_string(order);
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
      out +=
          csv_cell(f.filter) + ',' + quantity + ',' + unit + ',' + (value ? shortest(*value) : "") + "\r\n";
    };
    row("ipqn_within_10_percent_above", "counts/sample", f.within_10_percent);
    row("ipqn_within_1_percent_above", "counts/sample", f.within_1_percent);
    row("noise_rise_time", "s", f.rise_time);
  }
  return out;
}

}  // namespace qerr
