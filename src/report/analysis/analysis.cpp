#include "qerr/report/analysis.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "bound/batched_error.hpp"
#include "bound/noise_in_motion.hpp"
#include "core/parallel.hpp"
#include "core/text.hpp"
#include "kinematics/inverse_dynamics.hpp"
#include "kinematics/kernels.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "qerr/report/filter_report.hpp"
#include "report/analysis/effects.hpp"
#include "report/analysis/figures.hpp"
#include "report/analysis/tables.hpp"
#include "report/text_table.hpp"
#include "simulate/along_motion.hpp"
#include "simulate/unrounded_record.hpp"

namespace qerr {

namespace {

/// Relative variance below this is the square of a rounding error (1e-12 of sigma).
constexpr double rounding = 1e-24;

/// Within 5 degrees of the gimbal lock a roll or yaw error is more than ten times the rotation that causes
/// it.
constexpr double near_gimbal_lock = 0.0872;

/// The accuracy of IPQN without a motion, in one sentence.
std::string warning_of_ipqn(const Spec& spec) {
  std::string thresholds;
  for (const NamedFilter& f : spec.filters) {
    if (f.filter.derivative == 0) continue;
    const auto memory = autocorrelation_within(f.filter, 2 * longest_threshold_search);
    const auto threshold = memory ? ipqn_threshold(*memory, 0.1) : std::nullopt;
    if (threshold)
      thresholds += (thresholds.empty() ? "" : ", ") + ("'" + f.name + "' ") + significant(*threshold, 2);
  }
  return "sigma of a derivative assumes white noise (IPQN): right on average over speeds, at no constant "
         "speed "
         "exactly, and within 10 % along slow sines only above a peak speed" +
         (thresholds.empty() ? "" : " of " + thresholds + " counts a sample") +
         "; add `motion:` to get sigma at your speeds";
}

/// @param known  of noise_in_motion
std::vector<std::string> warnings_of_derivatives(const Spec& spec, const std::vector<Eigen::VectorXd>& known,
                                                 const Workspace& w,
                                                 const std::vector<EffectShare>& effects) {
  std::vector<std::string> warnings;
  const bool without_sigma =
      std::ranges::any_of(w.derivatives, [](const auto& row) { return !row.empty() && !row[0].sigma; });
  if (without_sigma)
    warnings.push_back(!spec.motion
                           ? "sigma behind a filter is not given: what effects, or errors within an "
                             "encoder's `accuracy`, add to it depends on the motion; add `motion:` (for "
                             "accuracy and play, velocity in the <limit> of the URDF's joints will do)"
                       : effects_follow_motion(spec)
                           ? "sigma behind a filter is not given: the load of an effect along `motion:` is "
                             "not known; give the URDF's links their masses"
                           : "sigma behind a filter is not given: `motion:` has too many samples for what "
                             "the effects add to it; shorten it");
  if (const std::string text = slow_error_assumption(spec, effects); !without_sigma && !text.empty())
    warnings.push_back(text);
  if (!spec.motion) warnings.push_back(warning_of_ipqn(spec));
  for (std::size_t f = 0; f < known.size(); ++f)
    if (!is_known(known, f))
      warnings.push_back(
          "filter '" + spec.filters[f].name +
          "': the motion has too many samples at its rate for sigma in motion, only IPQN is given");
  warnings.push_back(
      "worst case of a derivative assumes a Jacobian that is constant over the filter's memory");
  return warnings;
}

/// A requirement without a figure cannot be decided.
void require_answers(const Spec& spec, const std::vector<Eigen::VectorXd>& noise) {
  for (const Requirement& r : spec.requirements) {
    if (r.bound != Bound::sigma_in_motion) continue;
    if (is_known(noise, r.filter)) continue;
    throw requirement_error(r, "the motion has too many samples for sigma_in_motion",
                            "shorten the motion, lower the filter's sample rate, or ask for sigma");
  }
}

/// The error sources that the figures do not contain.
std::vector<std::string> warnings_of_scope(const Spec& spec, const std::vector<EffectShare>& effects) {
  const bool any = states_accuracy(spec) || std::ranges::any_of(effects, &EffectShare::included);
  std::vector<std::string> warnings;
  warnings.emplace_back(!any ? "quantization only: backlash, calibration, compliance and noise are not in "
                               "these figures"
                        : effects_follow_motion(spec)
                            ? "quantization and the effects of the spec: nothing else is in these figures; "
                              "effects add to every configuration what they add along `motion:`"
                            : "quantization and the effects of the spec: nothing else is in these "
                              "figures");
  const bool random = std::ranges::any_of(effects, [](const EffectShare& e) {
    return e.included && effect_kind(e.effect.type).random() && !is_zero(*e.share);
  });
  if (random)
    warnings.emplace_back("the worst case of noise and jitter is four sigma: single readings exceed it");
  append(warnings, effect_warnings(spec, effects));
  if (std::string assumed = warning_of_limits(spec, effects); !assumed.empty())
    warnings.push_back(std::move(assumed));
  return warnings;
}

std::vector<std::string> warnings_of(const Spec& spec, const Workspace& w,
                                     const std::vector<Eigen::VectorXd>& noise,
                                     const std::vector<EffectShare>& effects) {
  std::vector<std::string> warnings = spec.warnings;
  const auto& coordinates = spec.model.coordinates;
  const bool euler = std::ranges::any_of(
      coordinates, [](Coordinate c) { return c == Coordinate::roll || c == Coordinate::yaw; });
  if (euler && w.smallest_cosine_of_pitch < near_gimbal_lock)
    warnings.push_back(
        "roll and yaw: the samples come within " +
        shortest(std::round(10 * std::asin(w.smallest_cosine_of_pitch) * 180 / std::numbers::pi) / 10) +
        " deg of the gimbal lock (pitch = +-90 deg), where their errors grow without bound; use rx ry rz");
  const bool pitch = contains(coordinates, Coordinate::pitch);
  if (pitch && w.smallest_cosine_of_pitch < gimbal_lock)
    warnings.emplace_back(
        "pitch: a sample is at the gimbal lock (pitch = +-90 deg), where pitch has no rate, and its figures "
        "no bound; use rx ry rz");
  append(warnings, warnings_of_scope(spec, effects));
  if (std::string assumed = closed_loop_assumption(spec, effects); !assumed.empty())
    warnings.push_back(std::move(assumed));
  if (!spec.filters.empty()) append(warnings, warnings_of_derivatives(spec, noise, w, effects));
  append(warnings, filter_warnings(spec));
  append(warnings, count_rate_warnings(spec));
  if (!w.exact_percentiles) warnings.emplace_back("percentiles are counted in bins: right to 1e-3 relative");
  return warnings;
}

/// Sum over the position's coordinates (over all, if no position is analysed) of the contributions of each
/// encoder to the mean variance.
/// @param parts  coordinates x encoders
std::vector<double> by_encoder(const Analysis& a, const Eigen::MatrixXd& parts) {
  const auto& coordinates = a.spec.model.coordinates;
  const bool positions = std::ranges::any_of(coordinates, is_position);
  std::vector<double> sums(parts.cols());
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    if (is_position(coordinates[i]) != positions) continue;
    for (std::size_t e = 0; e < sums.size(); ++e) {
      const double part = parts(i, e);
      if (std::isfinite(part)) sums[e] += part;
    }
  }
  return sums;
}

/// Every encoder's part of the variance, with the effects of its joint along a motion, which are not sources
/// of the model: at the tip they have the column of the counts, in the ratio of their variance to Delta^2/12.
std::vector<double> variance_parts(const Analysis& a) {
  std::vector<double> parts = by_encoder(a, a.workspace.mean_variance_parts);
  if (!a.spec.model.along_motion) return parts;
  const std::vector<double> quantization = by_encoder(a, a.workspace.mean_quantization_parts);
  for (const EffectShare& s : a.effects) {
    const EffectKind& kind = effect_kind(s.effect.type);
    const bool source = kind.stage == Stage::line || kind.random() || kind.stage == Stage::kinematics ||
                        (needs_effort({s.effect}) && !has_masses(a.spec.model.chain));
    if (!s.included || !s.share || source) continue;
    const double step = a.spec.model.transmission.encoders[s.joint].resolution;
    parts[s.joint] += 12 * std::pow(s.share->sigma / step, 2) * quantization[s.joint];
  }
  return parts;
}

}  // namespace

void add_effects(const EffectReport& effects, Spec& spec) {
  OperationalModel& model = spec.model;
  model.sources = effects.sources;
  model.along_motion = effects.along_motion;
  const Eigen::VectorXd factors = count_factors(spec);
  for (Eigen::Index i = 0; i < factors.size(); ++i) model.transmission.encoders[i].resolution *= factors[i];
}

Workspace workspace_with_quantization(const OperationalModel& model, const std::vector<Norms>& filters,
                                      const Configurations& configurations, const WorkspaceOptions& options) {
  if (filters.empty() || (model.sources.empty() && !model.along_motion))
    return workspace(model, filters, configurations, options);
  // As one more filter, which quantization passes unchanged and nothing else does.
  OperationalModel more = model;
  std::vector<Norms> norms = filters;
  norms.push_back({.h2 = 1, .h2_error = 0, .l1 = {1, 1}, .dc_gain = 1});
  for (IndependentError& source : more.sources) {
    if (source.sigma_ratios.empty())
      for (const Norms& n : filters) source.sigma_ratios.push_back(n.h2);
    source.sigma_ratios.push_back(0);
  }
  if (more.along_motion) {
    more.along_motion->filtered.push_back(more.along_motion->tip);
    SignalMoments& nothing = more.along_motion->filtered.back();
    nothing.mean.setZero();
    nothing.peak.setZero();
    nothing.covariance.setZero();
  }
  Workspace w = workspace(more, norms, configurations, options);
  const std::vector<DerivativeStatistics> quantization = std::move(w.derivatives.back());
  w.derivatives.pop_back();
  if (!w.filtered.empty()) w.filtered.pop_back();
  for (std::size_t f = 0; f < filters.size(); ++f)
    for (std::size_t c = 0; c < quantization.size(); ++c)
      w.derivatives[f][c].sigma_quantization = scaled(*quantization[c].sigma, filters[f].h2);
  return w;
}

Analysis analyze(const Spec& spec, const WorkspaceOptions& options, const ProofRequest& proofs) {
  return analyze(spec, effect_report(spec), options, proofs);
}

Analysis analyze(const Spec& spec, const WorkspaceOptions& options,
                 const std::function<void(const std::string&)>& csv, const ProofRequest& proofs) {
  EffectReport effects = effect_report(spec);
  Spec with_effects = spec;
  add_effects(effects, with_effects);
  WorkspaceOptions all = options;
  all.noise_in_motion = noise_in_motion(spec, options.threads);
  csv(per_configuration_header(spec, all.noise_in_motion));
  all.text = [&](const ConfigurationBatch& batch) {
    return per_configuration_rows(with_effects, all.noise_in_motion, batch);
  };
  all.write = csv;
  return analyze(spec, std::move(effects), all, proofs);
}

Analysis analyze(const Spec& spec, const WorkspaceOptions& options, ConfigurationColumns& columns,
                 const ProofRequest& proofs) {
  EffectReport effects = effect_report(spec);
  Spec with_effects = spec;
  add_effects(effects, with_effects);
  WorkspaceOptions all = options;
  all.noise_in_motion = noise_in_motion(spec, options.threads);
  columns.names = per_configuration_names(spec, all.noise_in_motion);
  const std::size_t count = columns.names.size();
  columns.values.assign(count, std::vector<double>(size(spec.configurations)));
  all.visit = [&](const ConfigurationBatch& batch) {
    if (options.visit) options.visit(batch);
    const std::vector<double> numbers = per_configuration_numbers(with_effects, all.noise_in_motion, batch);
    for (std::size_t i = 0; i < numbers.size(); ++i)
      columns.values[i % count][static_cast<std::size_t>(batch.first) + i / count] = numbers[i];
  };
  return analyze(spec, std::move(effects), all, proofs);
}

Analysis unbounded_analysis(const Spec& spec, EffectReport effects,
                            std::vector<Eigen::VectorXd> noise_in_motion) {
  require_answers(spec, noise_in_motion);
  Analysis a{spec, {}, {}, std::move(noise_in_motion), {}, std::move(effects.shares)};
  a.resolutions = resolutions(spec.model.transmission);
  add_effects(effects, a.spec);
  a.joints = joint_error(a.spec.model);
  if (spec.model.control) a.control = std::make_shared<const ControlReport>(control_report(a.spec));
  return a;
}

Analysis analysis_without_warnings(const Spec& spec, EffectReport effects, const WorkspaceOptions& options) {
  WorkspaceOptions all = options;
  if (all.noise_in_motion.empty()) all.noise_in_motion = noise_in_motion(spec, options.threads);
  Analysis a = unbounded_analysis(spec, std::move(effects), all.noise_in_motion);
  a.workspace = workspace_with_quantization(a.spec.model, filter_norms(spec), spec.configurations, all);
  return a;
}

Analysis analyze(const Spec& spec, EffectReport effects, const WorkspaceOptions& options,
                 const ProofRequest& proofs) {
  Analysis a = analysis_without_warnings(spec, std::move(effects), options);
  if (options.warnings) a.warnings = warnings_of(spec, a.workspace, a.noise_in_motion, a.effects);
  if (options.warnings && a.control) append(a.warnings, control_warnings(spec, *a.control));
  add_proofs(a, proofs, options.threads);
  return a;
}

std::vector<Eigen::VectorXd> noise_in_motion(const Spec& spec, unsigned threads) {
  if (!spec.motion) return {};
  const std::vector<Filter> filters = designed_filters(spec);
  const double settling = settling_time(*spec.motion, filters);
  const bool all_follow = effects_follow_motion(spec);
  std::vector<Effect> of_counts;
  for (const EffectShare& e : effects_by_range(spec).shares) {
    const EffectKind& kind = effect_kind(e.effect.type);
    // Where not all effects follow the motion, random ones are sources beside this noise.
    if (kind.stage <= Stage::decoder && !(e.share && is_zero(*e.share)) && (all_follow || !kind.scattering))
      of_counts.push_back(e.effect);
  }
  const Eigen::VectorXd factors = count_factors(spec);
  std::vector<Eigen::VectorXd> noise(filters.size());
  parallel_for(filters.size(), threads, [&](std::size_t f) {
    const auto sigma = sigma_along_motion(spec.model, of_counts, *spec.motion, filters[f], settling);
    if (sigma) noise[f] = (factors.array() > 0).select(sigma->array() / factors.array(), *sigma);
  });
  return noise;
}

std::string derivative_unit(std::string_view unit, const Filter& filter) {
  return unit_name(output_dimension(unit == "m" ? dimension::length : dimension::angle, filter));
}

std::vector<double> encoder_budget(const Analysis& a) {
  if (a.spec.model.coordinates.empty()) return {};
  std::vector<double> parts = variance_parts(a);
  const double total = std::accumulate(parts.begin(), parts.end(), 0.0);
  if (total > 0)
    for (double& part : parts) part = part > rounding * total ? part / total : 0;
  return parts;
}

std::vector<BudgetParts> budget_parts(const Analysis& a) {
  const std::vector<double> shares = encoder_budget(a);
  const std::vector<double> all = variance_parts(a);
  const std::vector<double> quantization = by_encoder(a, a.workspace.mean_quantization_parts);
  std::vector<BudgetParts> parts(shares.size());
  for (std::size_t e = 0; e < parts.size(); ++e) {
    if (!(shares[e] > 0)) continue;
    const Encoder& encoder = a.spec.model.transmission.encoders[e];
    const double over = shares[e] / all[e];
    // Both enter by the same column: their variances are in the ratio of A^2/2 to Delta^2/12.
    parts[e].quantization = over * quantization[e];
    parts[e].accuracy =
        6 * std::pow(std::hypot(encoder.accuracy, encoder.gear_accuracy) / encoder.resolution, 2) *
        parts[e].quantization;
    const double rest = shares[e] - parts[e].quantization - parts[e].accuracy;
    constexpr double cancelled = 1e-12;  // differences of sums of 1e4 and more terms
    parts[e].effects = rest > cancelled * shares[e] ? rest : 0;
  }
  return parts;
}

}  // namespace qerr
