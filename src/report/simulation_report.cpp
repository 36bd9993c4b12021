#include "qerr/report/simulation_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "qerr/kinematics/inverse_dynamics.hpp"
#include "qerr/report/effect_report.hpp"
#include "qerr/report/write.hpp"
#include "text_table.hpp"

namespace qerr {

namespace {

using Json = nlohmann::ordered_json;

std::string filter_name(const SimulationReport& r, std::size_t output) {
  return output == 0 ? "position" : r.spec.filters[output - 1].name;
}

std::string unit_of(const SimulationReport& r, std::size_t output, std::size_t coordinate) {
  return derivative_unit(r.spec.model.coordinates[coordinate],
                         output == 0 ? 0 : r.spec.filters[output - 1].filter.derivative);
}

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

std::string json(const SimulationReport& r) {
  Json results = Json::array();
  for (std::size_t o = 0; o < r.simulation.results.size(); ++o)
    for (std::size_t c = 0; c < r.simulation.results[o].size(); ++c) {
      const SimulatedSignal& s = r.simulation.results[o][c];
      results.push_back({{"filter", filter_name(r, o)},
                         {"coordinate", info(r.spec.model.coordinates[c]).name},
                         {"unit", unit_of(r, o, c)},
                         {"sigma_simulated", s.sigma_simulated},
                         {"sigma_lower", s.sigma_lower},
                         {"sigma_upper", s.sigma_upper},
                         {"mean_simulated", s.mean_simulated},
                         {"peak_simulated", s.peak_simulated},
                         {"sigma_ipqn", number(s.sigma_ipqn)},
                         {"sigma_ipqn_path", number(s.sigma_ipqn_path)},
                         {"sigma_exact", number(s.sigma_exact)},
                         {"worst_case", number(s.worst_case)},
                         {"worst_case_path", number(s.worst_case_path)},
                         {"ladder",
                          {{"varying_jacobian", number(s.ladder.varying_jacobian)},
                           {"joint_error", number(s.ladder.joint_error)},
                           {"correlated_joints", number(s.ladder.correlated_joints)},
                           {"nonlinear", number(s.ladder.nonlinear)}}}});
    }
  Json effects = Json::array();
  for (const Effect& effect : r.spec.effects) {
    Json row = {{"effect", effect.type}, {"joint", effect.joint}};
    for (const EffectParameter& p : effect_parameters(r.spec, effect)) row[p.name] = p.value;
    for (const auto& [name, choice] : effect.choices) row[name] = choice;
    effects.push_back(row);
  }
  Json source = {{"file", r.spec.file}, {"sha256", r.spec.sha256}};
  for (const auto& [key, value] : r.spec.overrides) source["set"].push_back({{"key", key}, {"value", value}});
  const Chain& chain = r.spec.model.chain;
  return Json{{"qerr", version()},
              {"command", "simulate"},
              {"spec", source},
              {"seed", r.seed},
              {"robot", {{"name", r.spec.robot_name}, {"base", chain.base}, {"tip", chain.tip}}},
              {"effects", effects},
              {"runs", r.simulation.runs},
              {"samples", r.simulation.samples},
              {"settling_samples", r.simulation.settling},
              {"results", results},
              {"warnings", r.warnings}}
             .dump(2) +
         "\n";
}

std::string csv(const SimulationReport& r) {
  std::string out =
      "filter,coordinate,unit,sigma_simulated,sigma_lower,sigma_upper,mean_simulated,peak_simulated,sigma_"
      "ipqn,"
      "sigma_ipqn_path,sigma_exact,worst_case,worst_case_path,varying_jacobian,joint_error,correlated_joints,"
      "nonlinear\r\n";
  for (std::size_t o = 0; o < r.simulation.results.size(); ++o)
    for (std::size_t c = 0; c < r.simulation.results[o].size(); ++c) {
      const SimulatedSignal& s = r.simulation.results[o][c];
      out += csv_cell(filter_name(r, o)) + ',' + std::string(info(r.spec.model.coordinates[c]).name) + ',' +
             unit_of(r, o, c);
      for (const double value :
           {s.sigma_simulated, s.sigma_lower, s.sigma_upper, s.mean_simulated, s.peak_simulated, s.sigma_ipqn,
            s.sigma_ipqn_path, s.sigma_exact, s.worst_case, s.worst_case_path, s.ladder.varying_jacobian,
            s.ladder.joint_error, s.ladder.correlated_joints, s.ladder.nonlinear})
        out += ',' + (std::isfinite(value) ? shortest(value) : std::string());
      out += "\r\n";
    }
  return out;
}

std::string ratio(double over, double under) {
  if (!(under > 0) || !std::isfinite(under)) return "";
  const double r = over / under;
  return r < 1000 ? shortest_of(r, 3) : r < 1e6 ? shortest_of(std::round(r), 6) : ">1e6";
}

std::string percent(double part) {
  if (!std::isfinite(part)) return "";
  if (std::abs(part) > 100) return ">10000 %";
  return std::abs(part) < 0.995 ? shortest_of(100 * part, 2) + " %"
                                : shortest_of(std::round(100 * part), 6) + " %";
}

/// What is left of a constant error is rounding of the computer, not of the encoder.
bool is_nothing(const SimulatedSignal& s) { return s.sigma_simulated <= 1e-6 * s.sigma_ipqn_path; }

std::string label_of(const SimulationReport& r, std::size_t output, std::size_t coordinate) {
  return escaped(filter_name(r, output), 40) + ' ' +
         std::string(info(r.spec.model.coordinates[coordinate]).name);
}

template <typename Visit>
void for_each_signal(const SimulationReport& r, Visit visit) {
  for (std::size_t o = 0; o < r.simulation.results.size(); ++o)
    for (std::size_t c = 0; c < r.simulation.results[o].size(); ++c)
      visit(r.simulation.results[o][c], label_of(r, o, c), unit_of(r, o, c));
}

std::string sigma_table(const SimulationReport& r) {
  bool has_means = false;
  for_each_signal(r, [&](const SimulatedSignal& s, const std::string&, const std::string&) {
    has_means |= std::abs(s.mean_simulated) > 0.5 * s.sigma_simulated && !is_nothing(s);
  });
  std::vector<std::vector<std::string>> rows{{"", "simulated", r.simulation.runs > 1 ? "95 %" : "within run",
                                              "IPQN", "sim/IPQN", "sim/path", "sim/exact", "peak",
                                              "worst case", "used"}};
  if (has_means) rows[0].insert(rows[0].begin() + 1, "mean");
  for_each_signal(r, [&](const SimulatedSignal& s, const std::string& label, const std::string& unit) {
    const double half = 0.5 * (s.sigma_upper - s.sigma_lower);
    const bool nothing = is_nothing(s), bounded = std::isfinite(s.worst_case_path) && s.worst_case_path > 0;
    rows.push_back({label, readable(nothing ? 0 : s.sigma_simulated, unit),
                    nothing ? "" : "+-" + percent(half / s.sigma_simulated), readable(s.sigma_ipqn, unit),
                    ratio(nothing ? 0 : s.sigma_simulated, s.sigma_ipqn),
                    ratio(nothing ? 0 : s.sigma_simulated, s.sigma_ipqn_path),
                    ratio(nothing ? 0 : s.sigma_simulated, s.sigma_exact), readable(s.peak_simulated, unit),
                    readable(s.worst_case_path, unit),
                    bounded ? percent(s.peak_simulated / s.worst_case_path) : ""});
    if (has_means) rows.back().insert(rows.back().begin() + 1, readable(s.mean_simulated, unit));
  });
  const bool gaussian = std::any_of(r.spec.effects.begin(), r.spec.effects.end(), [](const Effect& e) {
    return (e.type == "noise" || e.type == "timing_jitter") && e.number("sigma") > 0;
  });
  return aligned(rows) +
         (gaussian ? "  (the worst case of noise and jitter is four sigma, which now and then they exceed)\n"
                   : "");
}

std::string ladder_table(const SimulationReport& r) {
  std::vector<std::vector<std::string>> rows{
      {"", "sim/IPQN", "=", "varying Jacobian", "joint error", "correlated joints", "non-linear"}};
  for_each_signal(r, [&](const SimulatedSignal& s, const std::string& label, const std::string&) {
    rows.push_back({label, ratio(s.sigma_simulated, s.sigma_ipqn), "=",
                    shortest_of(s.ladder.varying_jacobian, 4), shortest_of(s.ladder.joint_error, 4),
                    shortest_of(s.ladder.correlated_joints, 4), shortest_of(s.ladder.nonlinear, 5)});
  });
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
  std::vector<std::string> constant;
  for_each_signal(r, [&](const SimulatedSignal& s, const std::string& label, const std::string&) {
    const double off = s.sigma_ipqn > 0 ? s.sigma_simulated / s.sigma_ipqn - 1 : 0;
    if (!(std::abs(off) > noteworthy)) return;
    if (is_nothing(s)) {
      constant.push_back(label);
      return;
    }
    const std::array factors{s.ladder.varying_jacobian, s.ladder.joint_error, s.ladder.correlated_joints,
                             s.ladder.nonlinear};
    const auto worst = std::max_element(factors.begin(), factors.end(), [](double a, double b) {
      return std::abs(std::log(a)) < std::abs(std::log(b));
    });
    found[static_cast<std::size_t>(worst - factors.begin())].push_back(label + (off > 0 ? " (+" : " (") +
                                                                       percent(off) + ')');
  });
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
  line("the error is constant: the robot rests, or passes whole counts a sample", constant);
  return text.empty() ? "\nIPQN at the centre of the motion is within 5 % everywhere.\n"
                      : "\nIPQN at the centre of the motion is off by more than 5 %, mostly because\n" + text;
}

std::string table(const SimulationReport& r) {
  const Simulation& s = r.simulation;
  return "qerr simulate  robot '" + escaped(r.spec.robot_name, 60) + "', " + std::to_string(s.runs) +
         (s.runs == 1 ? " run of " : " runs of ") + std::to_string(s.samples) + " samples, the first " +
         std::to_string(s.settling) + " left out\n\n" +
         "Sigma: simulation beside theory (IPQN at the centre of the motion, along its path, exact at its "
         "speeds);\npeak beside the worst case along the path\n" +
         sigma_table(r) + "\nWhere the gap to IPQN comes from, in factors\n" + ladder_table(r) + causes(r);
}

}  // namespace

SimulationReport simulation_report(const Spec& spec, const SimulationOptions& options) {
  if (!spec.motion)
    throw Error(Fault{{spec.file, 1, 1},
                      "motion",
                      "the spec has no motion to simulate",
                      "",
                      "add motion: {sample_rate: 1 kHz, duration: 10 s, joints: {...}}"});
  if (needs_effort(spec.effects) && !has_masses(spec.model.chain))
    throw Error(Fault{{spec.file, 1, 1},
                      "effects",
                      "compliance winds up under a load that the URDF does not tell",
                      "no <inertial> between base and tip",
                      "give the links their masses"});
  const EffectReport effects = effect_report(spec);
  OperationalModel model = spec.model;
  model.sources = effects.sources;
  SimulationReport report{
      spec, simulate(model, designed_filters(spec), filter_norms(spec), *spec.motion, spec.effects, options),
      options.seed, spec.warnings};
  for (std::string& text : effect_warnings(spec, effects.shares)) report.warnings.push_back(std::move(text));
  return report;
}

std::string write(const SimulationReport& r, std::string_view format, const Style&) {
  return format == "json" ? json(r) : format == "csv" ? csv(r) : table(r);
}

}  // namespace qerr
