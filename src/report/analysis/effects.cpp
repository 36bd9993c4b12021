#include "report/analysis/effects.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "control/loop.hpp"
#include "core/lists.hpp"
#include "core/text.hpp"
#include "effect/action_path.hpp"
#include "effect/effects/effects.hpp"
#include "filter/run/cascade.hpp"
#include "input/joint_entries.hpp"
#include "kinematics/inverse_dynamics.hpp"
#include "qerr/core/error.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "qerr/encoder/encoder.hpp"
#include "simulate/along_motion.hpp"
#include "simulate/motion_path.hpp"
#include "simulate/sensing.hpp"
#include "simulate/unrounded_record.hpp"

namespace qerr {

namespace {

std::vector<Limits> sampled_ranges(const Spec& spec) {
  std::vector<Limits> ranges = spec.configurations.ranges;
  const auto& points = spec.configurations.points;
  if (points.empty()) return ranges;
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    ranges[i] = {points.front()[i], points.front()[i]};
    for (const Eigen::VectorXd& q : points)
      ranges[i] = {std::min(ranges[i].lower, q[i]), std::max(ranges[i].upper, q[i])};
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

bool on_encoder(const Spec& spec, const Effect& e, std::size_t encoder) {
  return independent_index(spec.model.chain, e.joint) == encoder;
}

/// Whether a counter of the encoder jumps: bounds of everything on its decoder are then by range, as the peak
/// of the mean over the zeros is not that of a single one.
bool decoder_jumps(const Spec& spec, std::size_t encoder) {
  return std::ranges::any_of(spec.effects, [&](const Effect& e) {
    return effect_kind(e.type).jumps && on_encoder(spec, e, encoder);
  });
}

bool has_closed_signals(const Spec& spec) {
  return std::ranges::any_of(spec.model.signals, [](const Signal& s) { return is_closed(s); });
}

/// [joint]: its loop at the inertia that the spec states; empty: none is stated, or the loop is unstable.
std::vector<std::optional<ClosedLoop>> stated_loops(const Spec& spec) {
  std::vector<std::optional<ClosedLoop>> loops;
  for (std::size_t j = 0; spec.model.control && j < spec.model.control->joints.size(); ++j) {
    const JointController& c = spec.model.control->joints[j];
    loops.push_back(c.acts() && c.inertia && has_closed_signals(spec)
                        ? closed(loop_of(*spec.model.control, j, *c.inertia))
                        : std::nullopt);
  }
  return loops;
}

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// Part of a constant error that its standard deviation may be by rounding.
constexpr double constant_spread = 1e-12;

/// Part of a play by which a joint at rest may move by rounding.
constexpr double at_rest = 1e-9;

/// The effects of the spec along its motion, without the accuracy of its encoders.
///
/// - The play of a joint that the motion leaves at rest is a constant of unknown size and sign.
/// - What depends on the place within a line, or is random, is bounded by range: over all positions of the
///   line. Its sigma is part of noise_in_motion.
/// - The counts behind a decoder that jumps are bounded by range, too.
/// - All else is a signal; where it depends on the position, the displacement by half a count is a source.
class EffectsInMotion {
 public:
  explicit EffectsInMotion(const Spec& spec)
      : spec_(spec),
        filters_(designed_filters(spec)),
        norms_(filter_norms(spec)),
        settling_(settling_time(*spec.motion, filters_)),
        factors_(count_factors(spec)),
        usage_(usage_of(spec)) {}

  EffectReport report() {
    EffectReport report = effects_by_range(spec_);
    report.sources.clear();
    for (EffectShare& s : report.shares) add(s, report.sources);
    for (std::size_t e = 0; e < spec_.model.transmission.encoders.size(); ++e)
      add_change_with_zero(e, report.sources);
    if (signals_.empty() && floating_.empty()) return report;
    const Motion& motion = *spec_.motion;
    report.along_motion = effects_along_motion(spec_.model, signals_, motion, filters_, settling_);
    if (steady_.size() < signals_.size()) {
      const ErrorAlongMotion steady = effects_along_motion(spec_.model, steady_, motion, filters_, settling_);
      report.along_motion->tip.peak = steady.tip.peak;
      report.along_motion->joints.peak = steady.joints.peak;
      for (std::size_t f = 0; f < filters_.size(); ++f)
        report.along_motion->filtered[f].peak = steady.filtered[f].peak;
    }
    for (const Effect& e : floating_)
      add_either_way(effects_along_motion(spec_.model, {e}, motion, filters_, settling_),
                     *report.along_motion);
    widen(*report.along_motion);
    if (has_closed_signals(spec_)) report.along_motion->in_loops = in_loops();
    return report;
  }

 private:
  /// An error of either sign, and of any size up to that of a signal: with the mean square of a uniform one.
  static void add_either_way(const SignalMoments& largest, SignalMoments& sum) {
    sum.peak += largest.peak;
    sum.covariance += (largest.covariance + largest.mean * largest.mean.transpose()) / 3;
  }
  static void add_either_way(const ErrorAlongMotion& largest, ErrorAlongMotion& sum) {
    add_either_way(largest.joints, sum.joints);
    add_either_way(largest.tip, sum.tip);
    for (std::size_t f = 0; f < sum.filtered.size(); ++f)
      add_either_way(largest.filtered[f], sum.filtered[f]);
  }

  /// [joint]: what its loop, at a stated inertia, passes of the errors along the motion.
  std::vector<LoopRatio> in_loops() const {
    OperationalModel joints = spec_.model;
    joints.coordinates.clear();
    joints.signals.clear();
    for (const IndependentJoint& joint : joints.chain.independent)
      for (const Signal& s : find_signals(joints, "joint:" + joint.name)) joints.signals.push_back(s);
    std::vector<LoopRatio> ratios;
    for (const std::optional<ClosedLoop>& loop : stated_loops(spec_)) {
      const auto j = std::ssize(ratios);
      ratios.push_back({unknown, unknown});
      if (!loop) continue;
      const std::vector<Filter> both{loop->motion, loop->torque};
      const double settling = settling_time(*spec_.motion, both);
      ErrorAlongMotion error = effects_along_motion(joints, signals_, *spec_.motion, both, settling);
      for (const Effect& e : floating_)
        add_either_way(effects_along_motion(joints, {e}, *spec_.motion, both, settling), error);
      const double before = std::sqrt(error.tip.covariance(j, j));
      const auto ratio = [&](std::size_t f) {
        return before > 0 ? std::sqrt(error.filtered[f].covariance(j, j)) / before : 0;
      };
      ratios.back() = {ratio(0), ratio(1)};
    }
    return ratios;
  }

  /// A joint that the motion leaves at rest is at any place in its play.
  bool floats(const EffectShare& s) const {
    LoopReading r;
    add_to_reading(s.effect, spec_.model.transmission.encoders[s.joint], r);
    const auto& position = usage_.joints[s.joint].position;
    return r.play > 0 && position && position->half_width() <= at_rest * r.play;
  }

  void add(EffectShare& s, std::vector<IndependentError>& sources) {
    const EffectKind& kind = effect_kind(s.effect.type);
    const bool loaded = !needs_effort({s.effect}) || has_masses(spec_.model.chain);
    const bool tied = kind.stage == Stage::line || kind.random();
    if (!s.included || is_zero(*s.share) || !loaded || tied) {
      for (IndependentError& source : error_sources(spec_.model, {s}, norms_)) {
        if (tied) tie(s, source);
        sources.push_back(std::move(source));
      }
      // Noise smooths the jumps of the mean.
      if (s.included && kind.random() && decoder_jumps(spec_, s.joint)) signals_.push_back(s.effect);
      return;
    }
    if (floats(s)) {
      const EffectKind constant = offset_effect();
      floating_.push_back({std::string(constant.name),
                           s.effect.joint,
                           {{std::string(constant.parameters.front().name), s.share->half_width}},
                           {}});
      s.share->sigma /= std::numbers::sqrt3;
      return;
    }
    signals_.push_back(s.effect);
    if (kind.stage == Stage::kinematics) {
      displaced_ += std::abs(s.effect.number("length"));
      steady_.push_back(s.effect);
      return;
    }
    if (kind.stage == Stage::decoder && decoder_jumps(spec_, s.joint)) {
      sources.push_back(bounded(s.joint, s.share->half_width, s.share->mean));
    } else {
      steady_.push_back(s.effect);
      if (kind.count_error)
        sources.push_back(bounded(s.joint, kind.count_error(s.effect).excess *
                                               spec_.model.transmission.encoders[s.joint].resolution));
    }
    show(s, effect_along_motion(spec_.model, s.effect, *spec_.motion, settling_));
  }

  /// What the position of the zero within a count changes in the signals of an encoder.
  void add_change_with_zero(std::size_t encoder, std::vector<IndependentError>& sources) const {
    std::vector<Effect> on_position;
    for (const Effect& e : steady_)
      if (effect_kind(e.type).stage <= Stage::disc && on_encoder(spec_, e, encoder)) on_position.push_back(e);
    if (on_position.empty()) return;
    const double change = change_with_zero(spec_.model, on_position, encoder, *spec_.motion, settling_);
    if (change > 0) sources.push_back(bounded(encoder, multiplied(encoder) * change));
  }

  /// An error at an encoder that widens the bounds and adds nothing to sigma.
  IndependentError bounded(std::size_t encoder, double half_width, double mean = 0) const {
    return {.where = IndependentError::Where::encoder,
            .owner = encoder,
            .mean = mean,
            .half_width = half_width,
            .sigma_ratios = std::vector<double>(filters_.size(), 0.0)};
  }

  void tie(const EffectShare& s, IndependentError& source) {
    const double step = spec_.model.transmission.encoders[s.joint].resolution;
    source.in_counts =
        source.where == IndependentError::Where::encoder || spec_.model.transmission.coupling.is_identity();
    for (std::size_t f = 0; f < filters_.size() && s.share->spectrum == Spectrum::motion; ++f) {
      const Eigen::VectorXd behind =
          sigma_within_line(spec_.model, {s.effect}, *spec_.motion, filters_[f], settling_);
      source.sigma_ratios[f] = source.sigma > 0 ? step * behind[s.joint] / source.sigma : 0;
    }
    if (s.share->spectrum == Spectrum::white)
      source.half_width += (std::max(1.0, s.multiplied) - 1) * half(s);
    else if (source.where == IndependentError::Where::encoder)
      source.half_width += (multiplied(s.joint) - 1) * half(s);
  }

  static double half(const EffectShare& s) { return std::abs(s.share->mean) + s.share->half_width; }
  /// A decoder multiplies the errors before it.
  double multiplied(std::size_t encoder) const { return std::max(1.0, factors_[encoder]); }

  /// The share becomes what the effect adds alone.
  static void show(EffectShare& s, const SignalMoments& alone) {
    s.share->mean = alone.mean[0];
    s.share->half_width = std::max(0.0, alone.peak[0] - std::abs(alone.mean[0]));
    const double sigma = std::sqrt(std::max(0.0, alone.covariance(0, 0)));
    s.share->sigma = sigma > constant_spread * alone.peak[0] ? sigma : 0;
  }

  /// A displaced origin turns with the joints before it.
  void widen(ErrorAlongMotion& error) const {
    if (displaced_ == 0) return;
    const OperationalModel& model = spec_.model;
    const Eigen::VectorXd half_widths =
        0.5 * (model.transmission.coupling.magnitudes() * resolutions(model.transmission));
    double turned = 0;
    for (const ChainJoint& joint : model.chain.joints)
      if (!joint.prismatic) turned += displaced_ * std::abs(joint.multiplier) * half_widths[joint.coordinate];
    for (std::size_t c = 0; c < model.coordinates.size(); ++c) {
      if (!is_position(model.coordinates[c])) continue;
      error.tip.peak[c] += turned;
      for (std::size_t f = 0; f < norms_.size(); ++f)
        error.filtered[f].peak[c] += norms_[f].l1.upper * turned;
    }
  }

  const Spec& spec_;
  std::vector<Filter> filters_;
  std::vector<Norms> norms_;
  double settling_;
  Eigen::VectorXd factors_;
  RobotUsage usage_;
  std::vector<Effect> floating_;          // the largest errors of the plays of joints at rest
  std::vector<Effect> signals_, steady_;  // all, and those without jumps
  double displaced_ = 0;                  // lengths by which origins are displaced [m]
};

constexpr double gear_periods = 2;  ///< of a gear's error in a revolution of its fast shaft

/// Periods of a sine of the shaft per unit of the encoder's coordinate [1/rad or 1/m]; empty: not known.
std::optional<double> periods_per_unit(const Spec& spec, std::size_t encoder, const RobotUsage& usage) {
  const bool shaft = encoder_kind(spec.encoder_figures[encoder].kind).counts_per_rev ||
                     !spec.model.chain.independent[encoder].prismatic();
  if (shaft) return std::abs(spec.model.transmission.encoders[encoder].shaft_ratio) / (2 * std::numbers::pi);
  const auto& position = usage.encoders[encoder].position;
  if (!position || !(position->half_width() > 0)) return std::nullopt;
  return 0.5 / position->half_width();
}

/// Root mean square of |H| over the frequencies from 0 to `highest`.
double mean_response(const Filter& filter, double highest) {
  // Of f = highest u^2, as a loop may pass but the lowest thousandth: |H|^2 is smooth on a 2048th of u.
  constexpr int intervals = 2048;
  double sum = 0;
  for (int i = 0; i < intervals; ++i) {
    const double u = (i + 0.5) / intervals;
    sum += 2 * u * std::norm(response(filter, highest * u * u));
  }
  return std::sqrt(sum / intervals);
}

/// Root mean square of a filtered exp(j 2 pi periods x) along the motion: of sqrt(2) sin with any phase.
/// @param filters  that shall have settled
double response_along(const Spec& spec, std::size_t encoder, const Filter& filter, double periods,
                      const std::vector<Filter>& filters) {
  const double settling = settling_time(*spec.motion, filters);
  const double samples = std::floor(spec.motion->duration * filter.sample_rate + 0.5);
  if (!(samples >= 1 && samples <= static_cast<double>(longest_record))) return unknown;
  const MotionPath path(*spec.motion);
  const Eigen::RowVectorXd to_encoder = spec.model.transmission.coupling.inverse().row(encoder);
  // From the steady state for the first reading: zero states would add its step.
  Cascade<double> cosine(filter), sine(filter);
  const double at_start = to_encoder.dot(path.position(0));
  const double passed = filter.derivative == 0 ? dc_gain(filter) : 0;
  double sum = 0, counted = 0;
  for (double k = 0; k < samples; ++k) {
    const double x =
        2 * std::numbers::pi * periods * (to_encoder.dot(path.position(k / filter.sample_rate)) - at_start);
    const double c = cosine.step(std::cos(x) - 1) + passed, s = sine.step(std::sin(x));
    if (k / filter.sample_rate < settling) continue;
    sum += c * c + s * s;
    ++counted;
  }
  return counted > 0 ? std::sqrt(sum / counted) : unknown;
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
  const bool steps =
      std::ranges::any_of(report.shares, [](const EffectShare& s) { return s.reversals.has_value(); });
  report.sources = error_sources(spec.model, report.shares, filter_norms(spec),
                                 steps ? step_energies(designed_filters(spec)) : std::vector<double>{});
  return report;
}

bool effects_follow_motion(const Spec& spec) {
  if (!spec.motion || spec.effects.empty()) return false;
  const std::vector<Filter> filters = designed_filters(spec);
  return std::ranges::all_of(filters,
                             [&](const Filter& f) {
                               return UnroundedRecord(*spec.motion, f.sample_rate, 0).samples() <=
                                      longest_record;
                             }) &&
         spec.motion->duration * spec.motion->sample_rate <= static_cast<double>(longest_record);
}

Eigen::VectorXd count_factors(const Spec& spec) {
  Eigen::VectorXd factors = Eigen::VectorXd::Ones(std::ssize(spec.model.transmission.encoders));
  if (!effects_follow_motion(spec)) return factors;
  for (const Effect& e : spec.effects) {
    const auto count_error = effect_kind(e.type).count_error;
    const std::size_t encoder = independent_index(spec.model.chain, e.joint);
    if (count_error && !decoder_jumps(spec, encoder)) factors[encoder] *= count_error(e).factor;
  }
  return factors;
}

EffectReport effect_report(const Spec& spec) {
  EffectReport report = effects_follow_motion(spec) ? EffectsInMotion(spec).report() : effects_by_range(spec);
  const SlowErrorRatios ratios = slow_error_ratios(spec);
  for (IndependentError& source :
       accuracy_sources(spec.model.transmission.encoders, ratios.accuracy, ratios.gear_accuracy))
    report.sources.push_back(std::move(source));
  return report;
}

bool states_accuracy(const Spec& spec) {
  const auto& encoders = spec.model.transmission.encoders;
  return std::ranges::any_of(encoders,
                             [](const Encoder& e) { return e.accuracy > 0 || e.gear_accuracy > 0; });
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
  const auto of_error = std::ranges::find_if(spec.requirements, &Requirement::limits_error);
  if (of_error == spec.requirements.end() || unknown.empty()) return;
  throw Error(of_error->place, "requirements",
              quoted(of_error->quantity) + " cannot be decided: " + unknown.front(), "", "");
}

std::string effect_unit(const Spec& spec, const EffectShare& s) {
  const bool displaced = effect_kind(s.effect.type).stage == Stage::kinematics;
  return displaced ? "m" : spec.model.chain.independent[s.joint].unit();
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

SlowErrorRatios slow_error_ratios(const Spec& spec) {
  const auto& encoders = spec.model.transmission.encoders;
  const std::vector<std::optional<ClosedLoop>> loops = stated_loops(spec);
  const SigmaRatios none{std::vector(spec.filters.size(), unknown),
                         std::vector(loops.size(), LoopRatio{unknown, unknown})};
  SlowErrorRatios ratios{std::vector(encoders.size(), none), std::vector(encoders.size(), none)};
  if (!states_accuracy(spec) || (spec.filters.empty() && loops.empty())) return ratios;
  const RobotUsage usage = usage_of(spec);
  for (std::size_t i = 0; i < encoders.size(); ++i) {
    const std::optional<double> periods = periods_per_unit(spec, i, usage);
    const auto& velocity = usage.encoders[i].velocity;
    if (!periods || !velocity) continue;
    const auto set = [&](double stated, double of_shaft, SigmaRatios& to) {
      if (!(stated > 0)) return;
      const auto ratio = [&](const Filter& filter, const std::vector<Filter>& settled) {
        return spec.motion ? response_along(spec, i, filter, of_shaft * *periods, settled)
                           : mean_response(filter, of_shaft * *periods * velocity->largest());
      };
      for (std::size_t f = 0; f < to.filters.size(); ++f)
        to.filters[f] = ratio(spec.filters[f].filter, designed_filters(spec));
      for (std::size_t j = 0; j < loops.size(); ++j) {
        if (!loops[j] || spec.model.transmission.coupling(j, i) == 0) continue;
        const std::vector<Filter> both{loops[j]->motion, loops[j]->torque};
        to.loops[j] = {ratio(loops[j]->motion, both), ratio(loops[j]->torque, both)};
      }
    };
    set(encoders[i].accuracy, 1, ratios.accuracy[i]);
    set(encoders[i].gear_accuracy, gear_periods, ratios.gear_accuracy[i]);
  }
  return ratios;
}

std::vector<double> step_energies(const std::vector<Filter>& filters) {
  std::vector<double> energies;
  for (const Filter& filter : filters) {
    constexpr double most = 1e6, left = 1e-9;
    const double modulus = poles_max_modulus(filter);
    const double memory = modulus > 0 ? std::log(left) / std::log(modulus) : 0;
    double& energy = energies.emplace_back(unknown);
    const double count = memory + static_cast<double>(filter.taps.size() + filter.sections.size()) + 8;
    if (filter.derivative == 0 || !(count < most)) continue;
    double step = 0, sum = 0, largest = 0;
    for (const double h : impulse_response(filter, static_cast<std::size_t>(count))) {
      step += h;
      largest = std::max(largest, std::abs(step));
      sum += step * step;
    }
    if (std::abs(step) <= 1e-6 * largest) energy = sum / filter.sample_rate;
  }
  return energies;
}

std::string slow_error_assumption(const Spec& spec, const std::vector<EffectShare>& effects) {
  if (spec.filters.empty()) return "";
  const bool play = !spec.motion && std::ranges::any_of(effects, [](const EffectShare& e) {
    return e.included && e.reversals.has_value();
  });
  std::string text;
  if (states_accuracy(spec))
    text =
        "an encoder's `accuracy` as a sine of one period a revolution of its shaft (of a gear: two; of a "
        "scale: one over the range)";
  if (play) text += std::string(text.empty() ? "" : ", ") + "play as a step at each end of the joint's range";
  if (text.empty()) return "";
  return std::string("sigma behind a filter") +
         (has_closed_signals(spec) && states_accuracy(spec) ? ", and in a loop of stated inertia," : "") +
         " takes " + text +
         (spec.motion ? ", along `motion:`"
                      : ", at speeds from 0 to the URDF's limits; add `motion:` to get it at yours");
}

std::string closed_loop_assumption(const Spec& spec, const std::vector<EffectShare>& effects) {
  if (!has_closed_signals(spec)) return "";
  const auto& joints = spec.model.control->joints;
  const bool varying =
      std::ranges::any_of(joints, [](const JointController& c) { return c.acts() && !c.inertia; });
  std::vector<std::string> by_norm;
  for (const EffectShare& e : effects)
    if (e.included && !is_zero(*e.share) && e.share->spectrum != Spectrum::white &&
        (varying || !effects_follow_motion(spec)) && !contains(by_norm, e.effect.type))
      by_norm.push_back(e.effect.type);
  const RobotUsage usage = usage_of(spec);
  const bool speeds_known =
      std::ranges::all_of(usage.encoders, [](const Usage& u) { return u.velocity.has_value(); });
  if (states_accuracy(spec) && (varying || !speeds_known)) by_norm.emplace_back("accuracy");
  if (by_norm.empty()) return "";
  return "sigma in closed loops takes " + joined(by_norm) +
         " by the l1 norm, rms times the most that a loop passes of any motion, which may be far too much; " +
         (varying ? "state the `inertia` of the joints in `control:`" : "add `motion:`");
}

}  // namespace qerr
