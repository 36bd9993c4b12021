#include "report/formats.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/text.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "report/analysis/effects.hpp"
#include "report/analysis/figures.hpp"
#include "report/analysis/tables.hpp"
#include "report/simulation/parts.hpp"
#include "report/text_table.hpp"
#include "simulate/along_motion.hpp"
#include "simulate/estimators/estimator.hpp"
#include "simulate/unrounded_record.hpp"

namespace qerr {

bool is_constant(const SimulatedSignal& s) {
  return std::isfinite(s.sigma_ipqn_path) && s.sigma_simulated <= 1e-6 * s.sigma_ipqn_path;
}

std::string label_of(const NamedSignal& s) { return escaped(s.filter, 40) + ' ' + s.coordinate; }

std::string speed_unit(const SimulationReport& r, const EstimatedVelocity& e) {
  return r.spec.model.chain.independent[e.joint].prismatic() ? "m/s" : "rad/s";
}

std::vector<EstimatedVelocity> estimator_comparison(const Spec& spec, const SimulationOptions& options) {
  std::vector<VelocityFilter> filters;
  for (const NamedFilter& f : spec.filters)
    if (f.filter.derivative == 1 && !f.controller && !has_unknown_unit(f.filter))
      filters.push_back({f.name, f.filter, f.norms, f.joints});
  if (filters.empty() && spec.estimators.empty())
    throw spec_error(spec, "estimators", "the spec has no velocity estimator to compare", "",
                     "add estimators: (qerr list estimators), or filters of derivative 1");
  const Motion& motion = *spec.motion;
  const double numbers = static_cast<double>((filters.size() + spec.estimators.size() + 1) *
                                             spec.model.chain.independent.size() * options.runs) *
                         motion.duration * motion.sample_rate;
  constexpr double most = 5e7;  // numbers that are kept: 400 MB
  if (numbers > most)
    throw spec_error(
        spec, "motion.duration", "the motion has too many samples for a comparison of estimators",
        significant(numbers, 3) + " estimates of at most 5e7", "shorten the motion, or ask for fewer runs");
  std::vector<Filter> designed;
  for (const VelocityFilter& f : filters) designed.push_back(f.filter);
  // Estimators have no settling time of their own: a twentieth of the motion unless the spec says otherwise.
  const double settling =
      motion.settling ? *motion.settling : std::max(settling_time(motion, designed), motion.duration / 20);
  return compare_velocities(spec.model, filters, spec.estimators, motion, spec.effects, settling, options);
}

std::vector<std::string> estimator_warnings(const Spec& spec) {
  std::string timed, unseen;
  const auto add = [](std::string& to, const std::string& name) {
    if (to.find(quoted(name)) == std::string::npos) to += (to.empty() ? "" : ", ") + quoted(name);
  };
  for (const EstimatorDesign& d : spec.estimators)
    if (estimator_kind(d.kind).timed) add(timed, d.name);
  for (const Effect& e : spec.effects)
    if (const EffectKind& kind = effect_kind(e.type); kind.action && acts_on_robot(kind) && has_size(e) &&
                                                      kind.stage != Stage::disc && kind.stage != Stage::line)
      add(unseen, e.type);
  if (timed.empty() || unseen.empty()) return {};
  return {"estimators that time edges (" + timed + ") see the motion and the disc alone: " + unseen +
          " of the spec " + (unseen.find(", ") == std::string::npos ? "is" : "are") +
          " in the rows of the others, and the ranking favours those that time edges"};
}

std::vector<double> cutoffs_between(double from, double to, std::size_t count) {
  std::vector<double> values;
  for (std::size_t i = 0; i < count; ++i) {
    const double way = static_cast<double>(i) / static_cast<double>(count - 1);
    values.push_back(rounded_to(from * std::pow(to / from, way), 4));
  }
  values.front() = from;
  values.back() = to;
  return values;
}

std::vector<CutoffChoice> cutoff_choices(const SimulationReport& r) {
  std::vector<CutoffChoice> choices;
  for (std::size_t i = 0; i < r.cutoffs->values.size(); ++i) {
    CutoffChoice choice{r.cutoffs->values[i], 0, 0, 0};
    const std::vector<SimulatedSignal>& signals = r.simulation.results[i + 1];
    for (std::size_t c = 0; c < signals.size(); ++c) {
      if (!is_position(r.spec.model.coordinates[c])) continue;
      const SimulatedSignal& s = signals[c];
      choice.noise = std::hypot(choice.noise, s.sigma_simulated, s.mean_simulated);
      choice.tracking = std::hypot(choice.tracking, s.tracking_rms);
      choice.total = std::hypot(choice.total, s.total_rms);
    }
    choices.push_back(choice);
  }
  return choices;
}

std::size_t best_of(const std::vector<CutoffChoice>& choices) {
  const auto best = std::ranges::min_element(
      choices, [](const CutoffChoice& a, const CutoffChoice& b) { return a.total < b.total; });
  return best - choices.begin();
}

std::string cutoff_unit(const SimulationReport& r) { return shown_unit("m", r.spec.filters[0].filter); }

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
  const bool has_means = std::ranges::any_of(signals, [](const NamedSignal& named) {
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
  const bool gaussian = std::ranges::any_of(
      r.spec.effects, [](const Effect& e) { return effect_kind(e.type).random() && has_size(e); });
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

/// What remains to be said of the deviations, at the end of the table.
std::string deviations(const SimulationReport& r) {
  const std::vector<IpqnDeviation> all = ipqn_deviations(r);
  if (all.empty()) return "\nIPQN at the centre of the motion is within 5 % everywhere.\n";
  std::string text = "\nIPQN at the centre of the motion is off by more than 5 %, mostly because\n";
  for (const auto& [why, signals] : all) text += "  " + why + ":\n    " + signals + '\n';
  return text;
}

/// Roll or yaw in a motion through the gimbal lock.
bool is_unbounded(const SimulatedSignal& s) {
  return !std::isfinite(s.sigma_ipqn) || !std::isfinite(s.ladder.joint_error);
}

using Cutoffs = In<CutoffSearch, SimulationReport>;
using ReportedEstimate = In<EstimatedVelocity, SimulationReport>;

/// An effect with its parameters beside its type.
Json reported_effects(const SimulationReport& r) {
  Json effects = Json::array();
  for (const Effect& effect : r.spec.effects) {
    Json entry = {{"effect", effect.type}, {"joint", effect.joint}};
    for (const EffectParameter& p : effect_parameters(r.spec, effect)) entry[p.name] = p.value;
    for (const auto& [name, choice] : effect.choices) entry[name] = choice;
    effects.push_back(entry);
  }
  return effects;
}

Schema effects_schema() {
  Json effect = schema_of(RowsOf<Effect>{{"effect", &Effect::type}, {"joint", &Effect::joint}}.list);
  effect["additionalProperties"] = {{"type", Json::array({"number", "string", "null"})}};
  return {schema::list(effect)};
}

const std::string& joint_of(const SimulationReport& r, const EstimatedVelocity& e) {
  return r.spec.model.chain.independent[e.joint].name;
}

/// Whether it times edges, beside effects that only estimators of counts see.
bool sees_less(const Spec& spec, const EstimatedVelocity& e) {
  const EstimatorDesign* const design = find_named(spec.estimators, e.estimator);
  return design && estimator_kind(design->kind).timed && !estimator_warnings(spec).empty();
}

std::vector<std::string> cells_of(const SimulationReport& r, const EstimatedVelocity& e) {
  const std::string unit = speed_unit(r, e);
  return {escaped(joint_of(r, e), 22) + ": " + escaped(e.estimator, 40),
          e.kind + (sees_less(r.spec, e) ? ", without effects" : ""),
          readable(e.rms, unit),
          e.delay ? readable(*e.delay, "s") : "none",
          readable(e.tracking, unit),
          readable(e.noise, unit),
          readable(e.worst, unit),
          e.worst_case ? readable(*e.worst_case, unit) : "-"};
}

const std::vector<std::string> heads{"joint: estimator", "kind",       "total", "delay",
                                     "by the delay",     "noise left", "worst", "bound"};
constexpr const char* legend =
    "total: rms of the estimate minus the true velocity; delay: by which the true velocity fits the estimate "
    "best; by the delay: rms of what it alone makes; noise left: rms about the late velocity; worst: largest "
    "error; bound: proven, of what the counts add to that of the delay";

/// The ranking of `simulate --estimators`: a row for each estimate, of each joint the best first.
std::string estimator_table(const SimulationReport& r, const Style& style) {
  TableRows rows{heads};
  for (const EstimatedVelocity& e : r.estimators) rows.push_back(cells_of(r, e));
  return heading("Velocity estimators along the motion, of each joint the least error first", style) +
         fitted_table(rows, style.width) + wrapped(legend, style.width, "  ");
}

std::string estimator_csv(const SimulationReport& r) {
  std::string out = "estimator,kind,coordinate,unit,rms,noise,tracking,delay,worst,worst_case\r\n";
  for (const EstimatedVelocity& e : r.estimators) {
    out += csv_cell(e.estimator) + ',' + e.kind + ',' + csv_cell(joint_of(r, e)) + ',' + speed_unit(r, e);
    for (const auto& value : {std::optional(e.rms), std::optional(e.noise), std::optional(e.tracking),
                              e.delay, std::optional(e.worst), e.worst_case})
      out += ',' + csv_number(value);
    out += "\r\n";
  }
  return out;
}

std::string cutoff_table(const SimulationReport& r, const Style& style) {
  const std::vector<CutoffChoice> choices = cutoff_choices(r);
  const std::size_t best = best_of(choices);
  const std::string unit = cutoff_unit(r);
  TableRows rows{{"cut-off", "encoder error", "tracking error", "total", ""}};
  for (std::size_t i = 0; i < choices.size(); ++i) {
    const CutoffChoice& c = choices[i];
    rows.push_back({readable(c.cutoff, "Hz"), readable(c.noise, unit), readable(c.tracking, unit),
                    readable(c.total, unit), i == best ? "<- least" : ""});
  }
  std::string coordinates;
  for (const Coordinate c : r.spec.model.coordinates)
    if (is_position(c)) coordinates += ' ' + std::string(info(c).name);
  const bool at_end = best == 0 || best + 1 == choices.size();
  const std::string remark =
      at_end
          ? "the least is at an end of the range: widen it"
          : "total: the estimate minus the true derivative; tracking error: what the filter does to the true "
            "signal";
  return heading("Filter '" + escaped(r.cutoffs->filter, 40) + "': root mean square errors of" + coordinates +
                     " together, along the motion",
                 style) +
         fitted_table(rows, style.width) + wrapped(remark, style.width, "  ");
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
    const auto worst = std::ranges::max_element(
        factors, [](double a, double b) { return std::abs(std::log(a)) < std::abs(std::log(b)); });
    found[worst - factors.begin()].push_back(label_of(named) + (off > 0 ? " (+" : " (") + percent(off) + ')');
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

std::string estimator_figures(const SimulationReport& r) {
  std::string out;
  TableRows rows;
  for (std::size_t i = 0; i < r.estimators.size(); ++i) {
    const EstimatedVelocity& first = r.estimators[i];
    rows.push_back(cells_of(r, first));
    if (i > 0 && r.estimators[i - 1].joint == first.joint) continue;
    page::Plot plot{page::isolated_runs("Error against speed of " + joint_of(r, first)),
                    "Rms error of each estimate in classes of the true speed.",
                    {"speed", speed_unit(r, first), true},
                    {"error, rms", speed_unit(r, first), true},
                    {}};
    for (std::size_t k = i; k < r.estimators.size() && r.estimators[k].joint == first.joint; ++k) {
      page::Series line{page::isolated_runs(r.estimators[k].estimator), {}};
      for (const ErrorAtSpeed& at : r.estimators[k].by_speed)
        if (at.speed > 0 && at.rms > 0) line.points.emplace_back(at.speed, at.rms);
      if (line.points.size() > 1) plot.series.push_back(line);
    }
    if (!plot.series.empty()) out += figure(plot);
  }
  return page::side_by_side(out) + page::table(heads, rows) + page::paragraph(legend);
}

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
  if (r.spec.model.coordinates.empty())
    return within(title +
                      "\nNo figure: only coordinates of the tip are compared, and the spec has none of them; "
                      "--log writes the joints' log.\n",
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

RowsOf<Ladder> rows(Of<Ladder>) {
  return {{"varying_jacobian", &Ladder::varying_jacobian, nullable},
          {"joint_error", &Ladder::joint_error, nullable},
          {"correlated_joints", &Ladder::correlated_joints, nullable},
          {"nonlinear", &Ladder::nonlinear, nullable}};
}

RowsOf<NamedSignal> rows(Of<NamedSignal>) {
  return {{"filter", &NamedSignal::filter, "\"position\" or the filter's name"},
          {"coordinate", &NamedSignal::coordinate},
          {"unit", &NamedSignal::unit},
          {"sigma_simulated", &SimulatedSignal::sigma_simulated, nullable},
          {"sigma_lower", &SimulatedSignal::sigma_lower, nullable},
          {"sigma_upper", &SimulatedSignal::sigma_upper, nullable},
          {"mean_simulated", &SimulatedSignal::mean_simulated, nullable},
          {"peak_simulated", &SimulatedSignal::peak_simulated, nullable},
          {"sigma_ipqn", &SimulatedSignal::sigma_ipqn, nullable},
          {"sigma_ipqn_path", &SimulatedSignal::sigma_ipqn_path, nullable},
          {"sigma_exact", &SimulatedSignal::sigma_exact, nullable},
          {"worst_case", &SimulatedSignal::worst_case, nullable},
          {"worst_case_path", &SimulatedSignal::worst_case_path, nullable},
          {"tracking_rms", &SimulatedSignal::tracking_rms, nullable},
          {"tracking_peak", &SimulatedSignal::tracking_peak, nullable},
          {"total_rms", &SimulatedSignal::total_rms, nullable},
          {"ladder", &SimulatedSignal::ladder, "factors from sigma_ipqn to sigma_simulated"}};
}

RowsOf<CutoffChoice> rows(Of<CutoffChoice>) {
  return {{"cutoff", &CutoffChoice::cutoff, "[Hz]"},
          {"encoder_rms", &CutoffChoice::noise, "by the errors of the encoders"},
          {"tracking_rms", &CutoffChoice::tracking, "by the filter"},
          {"total_rms", &CutoffChoice::total}};
}

RowsOf<Cutoffs> rows(Of<Cutoffs>) {
  return {{"filter", &CutoffSearch::filter},
          {"unit", [](auto& c) { return cutoff_unit(c.whole); }, "of the errors"},
          {"best",
           [](auto& c) {
             const std::vector<CutoffChoice> choices = cutoff_choices(c.whole);
             return choices[best_of(choices)].cutoff;
           },
           "the cut-off with the least total [Hz]"},
          {"choices", [](auto& c) { return cutoff_choices(c.whole); },
           "of the vector of the position's coordinates"}};
}

RowsOf<ErrorAtSpeed> rows(Of<ErrorAtSpeed>) {
  return {{"speed", &ErrorAtSpeed::speed}, {"rms", &ErrorAtSpeed::rms}};
}

RowsOf<ReportedEstimate> rows(Of<ReportedEstimate>) {
  using Estimated = EstimatedVelocity;
  return {{"estimator", &Estimated::estimator, "name in the spec"},
          {"kind", &Estimated::kind, "of `qerr list estimators`, or filter"},
          {"coordinate", [](auto& e) { return e.whole.spec.model.chain.independent[e->joint].name; },
           "the joint"},
          {"unit", [](auto& e) { return speed_unit(e.whole, *e); }},
          {"rms", &Estimated::rms, "of the estimate minus the true velocity"},
          {"noise", &Estimated::noise, "rms about the true velocity at the delay"},
          {"tracking", &Estimated::tracking, "rms of what the delay makes"},
          {"delay", &Estimated::delay, "that fits best [s]"},
          {"worst", &Estimated::worst, "largest error along the motion"},
          {"worst_case", &Estimated::worst_case, "bound of what the counts add; null: none is known"},
          {"by_speed", &Estimated::by_speed, "rms in classes of the speed"}};
}

RowsOf<SimulationReport> rows(Of<SimulationReport>) {
  return spec_header<SimulationReport>("simulate")
      .with({{"effects", reported_effects, effects_schema()},
             {"runs", [](auto& r) { return r.simulation.runs; }},
             {"samples", [](auto& r) { return r.simulation.samples; }, "of a run"},
             {"settling_samples", [](auto& r) { return r.simulation.settling; }, "discarded at the start"},
             {"results", signals_of},
             {"cutoffs", within(&SimulationReport::cutoffs), "with --cutoffs", optional},
             {"estimators", [](auto& r) { return items_of(r.estimators, r); },
              "with --estimators: of each joint the least error first", optional},
             {"warnings", &SimulationReport::warnings}});
}

std::string to_csv(const SimulationReport& r, const Style&) {
  return r.estimators.empty() ? csv_of(signals_of(r)) : estimator_csv(r);
}

}  // namespace qerr
