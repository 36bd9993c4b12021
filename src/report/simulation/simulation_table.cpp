#include <algorithm>
#include <array>
#include <cmath>

#include "core/text.hpp"
#include "report/simulation/simulation_writers.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

std::string ratio(double over, double under) {
  if (!(under > 0) || !std::isfinite(under)) return "";
  const double r = over / under;
  return r < 1000 ? significant(r, 3) : r < 1e6 ? significant(std::round(r), 6) : ">1e6";
}

std::string percent(double part) {
  if (!std::isfinite(part)) return "";
  if (std::abs(part) > 100) return ">10000 %";
  return std::abs(part) < 0.995 ? significant(100 * part, 2) + " %"
                                : significant(std::round(100 * part), 6) + " %";
}

/// What is left of a constant error is rounding of the computer, not of the encoder.
bool is_nothing(const SimulatedSignal& s) {
  return std::isfinite(s.sigma_ipqn_path) && s.sigma_simulated <= 1e-6 * s.sigma_ipqn_path;
}

/// Roll or yaw of a motion that meets the gimbal lock.
bool is_unbounded(const SimulatedSignal& s) {
  return !std::isfinite(s.sigma_ipqn) || !std::isfinite(s.ladder.joint_error);
}

std::string factor(double value, int digits) {
  return std::isfinite(value) ? significant(value, digits) : "";
}

std::string label_of(const NamedSignal& s) { return escaped(s.filter, 40) + ' ' + s.coordinate; }

std::string sigma_table(const SimulationReport& r) {
  bool has_means = false;
  for (const NamedSignal& named : signals_of(r)) {
    const SimulatedSignal& s = named.signal;
    has_means |= std::abs(s.mean_simulated) > 0.5 * s.sigma_simulated && !is_nothing(s);
  }
  std::vector<std::vector<std::string>> rows{{"", "simulated", r.simulation.runs > 1 ? "95 %" : "within run",
                                              "IPQN", "sim/IPQN", "sim/path", "sim/exact", "peak",
                                              "worst case", "used"}};
  if (has_means) rows[0].insert(rows[0].begin() + 1, "mean");
  for (const NamedSignal& named : signals_of(r)) {
    const SimulatedSignal& s = named.signal;
    const std::string& unit = named.unit;
    const double half = 0.5 * (s.sigma_upper - s.sigma_lower);
    const bool nothing = is_nothing(s), bounded = std::isfinite(s.worst_case_path) && s.worst_case_path > 0;
    rows.push_back({label_of(named), readable(nothing ? 0 : s.sigma_simulated, unit),
                    nothing ? "" : "+-" + percent(half / s.sigma_simulated), readable(s.sigma_ipqn, unit),
                    ratio(nothing ? 0 : s.sigma_simulated, s.sigma_ipqn),
                    ratio(nothing ? 0 : s.sigma_simulated, s.sigma_ipqn_path),
                    ratio(nothing ? 0 : s.sigma_simulated, s.sigma_exact), readable(s.peak_simulated, unit),
                    readable(s.worst_case_path, unit),
                    bounded ? percent(s.peak_simulated / s.worst_case_path) : ""});
    if (has_means) rows.back().insert(rows.back().begin() + 1, readable(s.mean_simulated, unit));
  }
  const bool gaussian = std::any_of(r.spec.effects.begin(), r.spec.effects.end(), [](const Effect& e) {
    return effect_kind(e.type).random() && has_size(e);
  });
  return aligned(rows) +
         (gaussian ? "  (the worst case of noise and jitter is four sigma, which now and then they exceed)\n"
                   : "");
}

std::string ladder_table(const SimulationReport& r) {
  std::vector<std::vector<std::string>> rows{
      {"", "sim/IPQN", "=", "varying Jacobian", "joint error", "correlated joints", "non-linear"}};
  for (const NamedSignal& named : signals_of(r)) {
    const SimulatedSignal& s = named.signal;
    rows.push_back({label_of(named), ratio(s.sigma_simulated, s.sigma_ipqn), "=",
                    factor(s.ladder.varying_jacobian, 4), factor(s.ladder.joint_error, 4),
                    factor(s.ladder.correlated_joints, 4), factor(s.ladder.nonlinear, 5)});
  }
  return aligned(rows);
}

/// Where IPQN misleads, under the factor that is most to blame.
std::string causes(const SimulationReport& r) {
  constexpr double noteworthy = 0.05;
  const bool ideal = r.spec.effects.empty();
  const std::array<const char*, 4> names{
      ideal ? "the Jacobian varies along the path"
            : "the Jacobian varies along the path, with constant errors too",
      ideal ? "the errors of the encoders are not white or not uniform" : "the joints err as the effects say",
      "joints err together",
      ideal ? "the kinematics are not linear" : "the kinematics are not linear, or not as built"};
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
    if (is_nothing(s)) {
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
  std::string text;
  const auto line = [&](const std::string& why, const std::vector<std::string>& labels) {
    if (labels.empty()) return;
    text += "  " + why + ": ";
    for (std::size_t k = 0; k < std::min<std::size_t>(labels.size(), 4); ++k)
      text += (k ? ", " : "") + labels[k];
    if (labels.size() > 4) text += " and " + std::to_string(labels.size() - 4) + " more";
    text += '\n';
  };
  for (std::size_t i = 0; i < found.size(); ++i) line(names[i], found[i]);
  line("IPQN has no bound at the gimbal lock, which the motion meets", unbounded);
  line("the error is constant: the robot rests, or passes whole counts a sample", constant);
  return text.empty() ? "\nIPQN at the centre of the motion is within 5 % everywhere.\n"
                      : "\nIPQN at the centre of the motion is off by more than 5 %, mostly because\n" + text;
}

}  // namespace

std::string simulation_table(const SimulationReport& r) {
  const Simulation& s = r.simulation;
  return "qerr simulate  robot '" + escaped(r.spec.robot_name, 60) + "', " + std::to_string(s.runs) +
         (s.runs == 1 ? " run of " : " runs of ") + std::to_string(s.samples) + " samples, the first " +
         std::to_string(s.settling) + " left out\n\n" +
         "Sigma: simulation beside theory (IPQN at the centre of the motion, along its path, exact at its "
         "speeds);\npeak beside the worst case along the path\n" +
         sigma_table(r) + "\nWhere the gap to IPQN comes from, in factors\n" + ladder_table(r) + causes(r);
}

}  // namespace qerr
