#include "report/analysis/effects.hpp"

#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "input/joint_entries.hpp"
#include "kinematics/inverse_dynamics.hpp"
#include "qerr/core/error.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "simulate/effects_along_motion.hpp"
#include "simulate/sensing.hpp"
#include "simulate/settling.hpp"
#include "simulate/unrounded_record.hpp"
#include "simulate/usage.hpp"

namespace qerr {

namespace {

std::vector<Limits> sampled_ranges(const Spec& spec) {
  std::vector<Limits> ranges = spec.configurations.ranges;
  const auto& points = spec.configurations.points;
  if (points.empty()) return ranges;
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    ranges[i] = {points.front()[row], points.front()[row]};
    for (const Eigen::VectorXd& q : points)
      ranges[i] = {std::min(ranges[i].lower, q[row]), std::max(ranges[i].upper, q[row])};
  }
  return ranges;
}

/// The quantity that is missing, and where to add it.
std::pair<const char*, const char*> lack(Need need, bool has_motion) {
  switch (need) {
    case Need::position:
      return {"the range of the joint", "add `motion:`"};
    case Need::velocity:
      return {"the speed of the joint", "add `motion:`, or velocity to the joint's <limit> in the URDF"};
    case Need::effort:
      return {"the load of the joint",
              has_motion ? "add <inertial> to the URDF's links, or effort to the joint's <limit>"
                         : "add `motion:` to a URDF with masses, or effort to the joint's <limit>"};
    case Need::temperature:
      return {"the temperature of the joint", "only a log can give it; leave the coefficient out"};
    case Need::duration:
      return {"the length of the motion", "add `motion:`"};
    case Need::nothing:
      break;
  }
  return {"", ""};
}

/// What the rounding error behind a decoder may exceed that of quantization by.
ErrorSource excess_of(const CountError& error, std::size_t encoder, const Spec& spec) {
  return {.where = ErrorSource::Where::encoder,
          .owner = encoder,
          .half_width = error.excess * spec.model.transmission.encoders[encoder].resolution,
          .sigma_ratios = std::vector<double>(spec.filters.size(), 0.0)};
}

}  // namespace

RobotUsage usage_of(const Spec& spec) {
  const RobotUsage limits = usage_from_limits(spec.model, sampled_ranges(spec));
  if (!spec.motion) return limits;
  double margin = 0;  // late readings at the start show the time before the motion
  for (const Effect& effect : spec.effects) margin += std::abs(effect.number_or("delay", 0));
  Motion motion = *spec.motion;
  motion.settling = settling_time(motion, designed_filters(spec));
  RobotUsage usage = usage_in_motion(spec.model, motion, std::min(margin, motion.duration));
  for (std::size_t i = 0; i < usage.joints.size(); ++i)
    if (!usage.joints[i].effort) usage.joints[i].effort = limits.joints[i].effort;
  return usage;
}

EffectReport effects_by_range(const Spec& spec) {
  if (spec.effects.empty()) return {};
  EffectReport report{effect_shares(spec.model, spec.effects, usage_of(spec)), {}};
  report.sources = error_sources(spec.model, report.shares, filter_norms(spec));
  return report;
}

bool effects_follow_motion(const Spec& spec) {
  if (!spec.motion || spec.effects.empty()) return false;
  const std::vector<Filter> filters = designed_filters(spec);
  return std::all_of(filters.begin(), filters.end(),
                     [&](const Filter& f) {
                       return UnroundedRecord(*spec.motion, f.sample_rate, 0).samples() <= longest_record;
                     }) &&
         spec.motion->duration * spec.motion->sample_rate <= static_cast<double>(longest_record);
}

Eigen::VectorXd count_factors(const Spec& spec) {
  Eigen::VectorXd factors =
      Eigen::VectorXd::Ones(static_cast<Eigen::Index>(spec.model.transmission.encoders.size()));
  if (!effects_follow_motion(spec)) return factors;
  for (const Effect& e : spec.effects)
    if (const auto count_error = effect_kind(e.type).count_error)
      factors[static_cast<Eigen::Index>(independent_index(spec.model.chain, e.joint))] *=
          count_error(e).factor;
  return factors;
}

namespace {

/// Part of a constant error that its standard deviation may be by rounding.
constexpr double constant_spread = 1e-12;

/// The effects of the spec, without the accuracy of its encoders.
EffectReport effects_in_motion(const Spec& spec) {
  EffectReport report = effects_by_range(spec);
  if (!effects_follow_motion(spec)) return report;
  const std::vector<Filter> filters = designed_filters(spec);
  const double settling = settling_time(*spec.motion, filters);
  std::vector<Effect> signals;
  std::vector<ErrorSource> excess;
  std::vector<EffectShare> others;
  for (EffectShare& s : report.shares) {
    const bool loaded = !needs_effort({s.effect}) || has_masses(spec.model.chain);
    if (!s.included || s.share->spectrum == Spectrum::white || is_zero(*s.share) || !loaded) {
      others.push_back(s);
      continue;
    }
    signals.push_back(s.effect);
    if (const auto count_error = effect_kind(s.effect.type).count_error)
      excess.push_back(excess_of(count_error(s.effect), s.joint, spec));
    if (effect_kind(s.effect.type).stage == Stage::kinematics) continue;
    const SignalMoments alone = effect_along_motion(spec.model, s.effect, *spec.motion, settling);
    s.share->mean = alone.mean[0];
    s.share->half_width = std::max(0.0, alone.peak[0] - std::abs(alone.mean[0]));
    const double sigma = std::sqrt(std::max(0.0, alone.covariance(0, 0)));
    s.share->sigma = sigma > constant_spread * alone.peak[0] ? sigma : 0;
  }
  report.sources = error_sources(spec.model, others, filter_norms(spec));
  report.sources.insert(report.sources.end(), excess.begin(), excess.end());
  if (!signals.empty())
    report.along_motion = effects_along_motion(spec.model, signals, *spec.motion, filters, settling);
  return report;
}

}  // namespace

EffectReport effect_report(const Spec& spec) {
  EffectReport report = effects_in_motion(spec);
  for (ErrorSource& source : accuracy_sources(spec.model.transmission.encoders, spec.filters.size()))
    report.sources.push_back(std::move(source));
  return report;
}

bool states_accuracy(const Spec& spec) {
  const auto& encoders = spec.model.transmission.encoders;
  return std::any_of(encoders.begin(), encoders.end(), [](const Encoder& e) { return e.accuracy > 0; });
}

std::vector<std::string> effect_warnings(const Spec& spec, const std::vector<EffectShare>& shares) {
  std::vector<std::string> warnings;
  for (const EffectShare& s : shares) {
    if (s.share) continue;
    const auto [what, remedy] = lack(effect_kind(s.effect.type).need, spec.motion.has_value());
    warnings.push_back("effect '" + s.effect.type + "' of joint '" + s.effect.joint +
                       "' is not in these figures: " + what + " is not known; " + remedy);
  }
  return warnings;
}

std::string warning_of_limits(const Spec& spec, const std::vector<EffectShare>& shares) {
  if (spec.motion || !has_masses(spec.model.chain)) return "";
  std::vector<std::string> joints;
  for (const EffectShare& s : shares)
    if (s.included && !is_zero(*s.share) && needs_effort({s.effect})) joints.push_back(s.effect.joint);
  if (joints.empty()) return "";
  return "the loads of " + list_of_names(joints) +
         " are +- the effort limits of the URDF, not those of its masses: gravity is ignored, although the "
         "masses "
         "are known; add `motion:`, also one at rest, and the loads follow from masses and motion";
}

void require_known(const Spec& spec, const std::vector<EffectShare>& shares) {
  const std::vector<std::string> unknown = effect_warnings(spec, shares);
  if (spec.requirements.empty() || unknown.empty()) return;
  throw Error(
      {spec.requirements.front().place, "requirements", "cannot be decided: " + unknown.front(), "", ""});
}

std::string effect_unit(const Spec& spec, const EffectShare& s) {
  const bool displaced = effect_kind(s.effect.type).stage == Stage::kinematics;
  return displaced || spec.model.chain.independent[s.joint].prismatic() ? "m" : "rad";
}

std::vector<EffectParameter> effect_parameters(const Spec& spec, const Effect& effect) {
  const Chain& chain = spec.model.chain;
  const bool prismatic = chain.independent[independent_index(chain, effect.joint)].prismatic();
  std::vector<EffectParameter> list;
  for (const Parameter& row : effect_kind(effect.type).parameters) {
    const auto number = effect.numbers.find(std::string(row.name));
    if (number == effect.numbers.end()) continue;
    list.push_back({number->first, number->second, unit_name(dimension_at(row, prismatic)),
                    row.fallback && *row.fallback == number->second});
  }
  return list;
}

}  // namespace qerr
