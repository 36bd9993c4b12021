#include <algorithm>
#include <array>
#include <cmath>

#include "core/text.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "report/formats.hpp"
#include "report/simulation/parts.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

std::string ratio_text(double over, double under) {
  if (!(under > 0) || !std::isfinite(under)) return "";
  const double r = over / under;
  return r < 1000 ? significant(r, 3) : r < 1e6 ? significant(std::round(r), 6) : ">1e6";
}

std::string factor(double value, int digits) {
  return std::isfinite(value) ? significant(value, digits) : "";
}

std::string sigma_table(const SimulationReport& r, const Style& style) {
  TableRows rows{{"", "simulated", "interval", "IPQN", "sim/IPQN", "sim/path", "sim/exact"}};
  for (const NamedSignal& named : signals_of(r)) {
    const SimulatedSignal& s = named.signal;
    const double sigma = is_constant(s) ? 0 : s.sigma_simulated, half = 0.5 * (s.sigma_upper - s.sigma_lower);
    rows.push_back({label_of(named), readable(sigma, named.shown_unit),
                    is_constant(s) ? "" : "+-" + percent(half / s.sigma_simulated),
                    readable(s.sigma_ipqn, named.shown_unit), ratio_text(sigma, s.sigma_ipqn),
                    ratio_text(sigma, s.sigma_ipqn_path), ratio_text(sigma, s.sigma_exact)});
  }
  return fitted_table(rows, style.width) + (r.simulation.runs > 1
                                                ? "  interval: 95 %, over the runs\n"
                                                : "  interval: single-run interval, 95 %\n");
}

/// Means are shown if one of them is not small compared with its sigma.
std::string peak_table(const SimulationReport& r, const Style& style) {
  const std::vector<NamedSignal> signals = signals_of(r);
  const bool has_means = std::any_of(signals.begin(), signals.end(), [](const NamedSignal& named) {
    const SimulatedSignal& s = named.signal;
    return std::abs(s.mean_simulated) > 0.5 * s.sigma_simulated && !is_constant(s);
  });
  TableRows rows{{"", "peak", "worst case", "% of the bound"}};
  if (has_means) rows[0].insert(rows[0].begin() + 1, "mean");
  for (const NamedSignal& named : signals) {
    const SimulatedSignal& s = named.signal;
    const bool bounded = std::isfinite(s.worst_case_path) && s.worst_case_path > 0;
    rows.push_back({label_of(named), readable(s.peak_simulated, named.shown_unit),
                    readable(s.worst_case_path, named.shown_unit),
                    bounded ? percent(s.peak_simulated / s.worst_case_path) : ""});
    if (has_means) rows.back().insert(rows.back().begin() + 1, readable(s.mean_simulated, named.shown_unit));
  }
  const bool gaussian = std::any_of(r.spec.effects.begin(), r.spec.effects.end(), [](const Effect& e) {
    return effect_kind(e.type).random() && has_size(e);
  });
  return fitted_table(rows, style.width) +
         (gaussian ? "  (the worst case of noise and jitter is four sigma, which they exceed occasionally)\n"
                   : "");
}

/// Noise and tracking errors, where these were asked for.
std::string tracking_table(const SimulationReport& r, const Style& style) {
  TableRows rows{{"", "encoder error", "tracking error", "its peak", "total"}};
  for (auto& cells : tracking_cells(r)) rows.push_back(std::move(cells));
  if (rows.size() == 1) return "";
  return heading("Root mean square errors of the estimates: by the encoders and by the filter", style) +
         fitted_table(rows, style.width);
}

}  // namespace

TableRows factor_cells(const SimulationReport& r) {
  TableRows rows{{"", "sim/IPQN", "=", "Jacobian", "joint error", "correlation", "non-linear"}};
  for (const NamedSignal& named : signals_of(r)) {
    const SimulatedSignal& s = named.signal;
    rows.push_back({label_of(named), ratio_text(s.sigma_simulated, s.sigma_ipqn), "=",
                    factor(s.ladder.varying_jacobian, 4), factor(s.ladder.joint_error, 4),
                    factor(s.ladder.correlated_joints, 4), factor(s.ladder.nonlinear, 5)});
  }
  return rows;
}

namespace {

/// What remains to be said of the deviations, at the end of the table.
std::string deviations(const SimulationReport& r) {
  const std::vector<IpqnDeviation> all = ipqn_deviations(r);
  if (all.empty()) return "\nIPQN at the centre of the motion is within 5 % everywhere.\n";
  std::string text = "\nIPQN at the centre of the motion is off by more than 5 %, mostly because\n";
  for (const auto& [why, signals] : all) text += "  " + why + ":\n    " + signals + '\n';
  return text;
}

}  // namespace

std::string to_table(const SimulationReport& r, const Style& style) {
  const Simulation& s = r.simulation;
  const std::string title = painted("qerr simulate", Paint::bold, style) + "  robot '" +
                            escaped(r.spec.robot_name, 60) + "', " + std::to_string(s.runs) +
                            (s.runs == 1 ? " run of " : " runs of ") + std::to_string(s.samples) +
                            " samples, the first " + std::to_string(s.settling) + " discarded\n";
  if (!r.estimators.empty()) return within(title + estimator_table(r, style), style.width);
  if (r.cutoffs) return within(title + cutoff_table(r, style), style.width);
  if (r.spec.model.tips)
    return within(title +
                      "\nNo figure: of several tips none is compared; --log writes the joints' log, and with "
                      "one `robot.tip` "
                      "its errors are.\n",
                  style.width);
  const std::string exact =
      r.spec.effects.empty() ? "exact at its speeds" : "exact at its speeds for quantization alone";
  return within(
      title +
          heading("Sigma: simulation compared with theory (IPQN at the centre of the motion, along its path, "
                  "and " +
                      exact + ")",
                  style) +
          sigma_table(r, style) + heading("Peak compared with the worst case along the path", style) +
          peak_table(r, style) + tracking_table(r, style) +
          heading("Factors from IPQN to the simulation", style) + fitted_table(factor_cells(r), style.width) +
          deviations(r),
      style.width);
}

bool is_constant(const SimulatedSignal& s) {
  return std::isfinite(s.sigma_ipqn_path) && s.sigma_simulated <= 1e-6 * s.sigma_ipqn_path;
}

bool is_unbounded(const SimulatedSignal& s) {
  return !std::isfinite(s.sigma_ipqn) || !std::isfinite(s.ladder.joint_error);
}

std::string label_of(const NamedSignal& s) { return escaped(s.filter, 40) + ' ' + s.coordinate; }

std::vector<IpqnDeviation> ipqn_deviations(const SimulationReport& r) {
  constexpr double noteworthy = 0.05;
  const bool ideal = r.spec.effects.empty();
  const std::array<const char*, 4> names{
      ideal ? "the Jacobian varies along the path"
            : "the Jacobian varies along the path, with constant errors too",
      ideal ? "the errors of the encoders are not white or not uniform"
            : "the effects add errors at the joints",
      "the errors of the joints are correlated",
      ideal ? "the kinematics are not linear" : "the kinematics are not linear, or not those of the model"};
  std::array<std::vector<std::string>, 4> found;
  std::vector<std::string> constant, unbounded;
  for (const NamedSignal& named : signals_of(r)) {
    const SimulatedSignal& s = named.signal;
    if (is_unbounded(s)) {
      unbounded.push_back(label_of(named));
      continue;
    }
    const double off = s.sigma_ipqn > 0 ? s.sigma_simulated / s.sigma_ipqn - 1 : 0;
    if (!(std::abs(off) > noteworthy)) continue;
    if (is_constant(s)) {
      constant.push_back(label_of(named));
      continue;
    }
    const std::array factors{s.ladder.varying_jacobian, s.ladder.joint_error, s.ladder.correlated_joints,
                             s.ladder.nonlinear};
    const auto worst = std::max_element(factors.begin(), factors.end(), [](double a, double b) {
      return std::abs(std::log(a)) < std::abs(std::log(b));
    });
    found[static_cast<std::size_t>(worst - factors.begin())].push_back(
        label_of(named) + (off > 0 ? " (+" : " (") + percent(off) + ')');
  }
  std::vector<IpqnDeviation> all;
  const auto add = [&](const std::string& why, const std::vector<std::string>& labels) {
    if (labels.empty()) return;
    constexpr std::size_t most = 3;
    std::string text;
    for (std::size_t k = 0; k < std::min(labels.size(), most); ++k) text += (k ? ", " : "") + labels[k];
    if (labels.size() > most) text += " and " + std::to_string(labels.size() - most) + " more";
    all.push_back({why, text});
  };
  for (std::size_t i = 0; i < found.size(); ++i) add(names[i], found[i]);
  add("IPQN is unbounded at the gimbal lock, which the motion passes", unbounded);
  add("the error is constant: no motion, or whole counts per sample", constant);
  return all;
}

TableRows tracking_cells(const SimulationReport& r) {
  TableRows rows;
  for (const NamedSignal& named : signals_of(r)) {
    const SimulatedSignal& s = named.signal;
    if (named.filter == "position" || std::isnan(s.tracking_rms)) continue;
    rows.push_back({label_of(named),
                    readable(std::hypot(s.sigma_simulated, s.mean_simulated), named.shown_unit),
                    readable(s.tracking_rms, named.shown_unit), readable(s.tracking_peak, named.shown_unit),
                    readable(s.total_rms, named.shown_unit)});
  }
  return rows;
}

}  // namespace qerr
