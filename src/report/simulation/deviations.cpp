#include <algorithm>
#include <array>
#include <cmath>

#include "core/text.hpp"
#include "report/simulation/signals.hpp"
#include "report/text_table.hpp"

namespace qerr {

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

std::vector<std::vector<std::string>> tracking_cells(const SimulationReport& r) {
  std::vector<std::vector<std::string>> rows;
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
