#include "qerr/bound/effect_shares.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "control/control.hpp"
#include "effect/action_path.hpp"
#include "qerr/bound/independent_error.hpp"
#include "qerr/effect/effect_kind.hpp"

namespace qerr {

namespace {

/// Whether effects of the stage act on the joint's coordinate, not on the encoder's.
bool at_joint(Stage stage) { return stage == Stage::clock || stage == Stage::link || stage == Stage::gear; }

double worst(const Share& s) { return std::abs(s.mean) + s.half_width; }

/// The usage with an additional position error of at most `by`, of which `white` is independent from sample
/// to sample.
Usage widened(Usage usage, double by, double white) {
  if (usage.position) {
    usage.position->lower -= by;
    usage.position->upper += by;
    usage.position->mean_square += (by - white) * (by - white + 2 * usage.position->rms());
  }
  return usage;
}

/// Spread of a quantity of one encoder coordinate, a weighted sum over the joints (a row of C^-1): extremes
/// may coincide, deviations are independent.
std::optional<Spread> combined(const Eigen::RowVectorXd& weights, const std::vector<Usage>& joints,
                               std::optional<Spread> Usage::*quantity) {
  Spread sum;
  double variance = 0;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const double w = weights[j];
    if (w == 0) continue;
    const auto& s = joints[j].*quantity;
    if (!s) return std::nullopt;
    sum.lower += std::min(w * s->lower, w * s->upper);
    sum.upper += std::max(w * s->lower, w * s->upper);
    sum.mean += w * s->mean;
    variance += w * w * (s->mean_square - s->mean * s->mean);
  }
  sum.mean_square = variance + sum.mean * sum.mean;
  return sum;
}

Spread uniform(double lower, double upper) {
  const double mean = 0.5 * (lower + upper), half = 0.5 * (upper - lower);
  return {lower, upper, mean, mean * mean + half * half / 3};
}

double sigma_ratio(const EffectShare& s, const Norms& norms, std::optional<double> step_energy) {
  switch (s.share->spectrum) {
    case Spectrum::constant:
      return std::abs(norms.dc_gain);
    case Spectrum::motion:
      break;
    case Spectrum::white:
      return norms.h2;
  }
  if (s.reversals && step_energy && s.share->sigma > 0)
    return s.share->step_at_reversal / s.share->sigma * std::sqrt(*step_energy * *s.reversals);
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

Spread spread_of(std::span<const double> samples) {
  Spread s{samples.front(), samples.front(), 0, 0};
  for (const double x : samples) {
    s.lower = std::min(s.lower, x);
    s.upper = std::max(s.upper, x);
    s.mean += x;
    s.mean_square += x * x;
  }
  s.mean /= static_cast<double>(samples.size());
  s.mean_square /= static_cast<double>(samples.size());
  return s;
}

RobotUsage usage_from_limits(const OperationalModel& model, const std::vector<Limits>& ranges) {
  RobotUsage usage;
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const IndependentJoint& joint = model.chain.independent[i];
    Usage& u = usage.joints.emplace_back();
    if (std::isfinite(ranges[i].lower) && std::isfinite(ranges[i].upper))
      u.position = uniform(ranges[i].lower, ranges[i].upper);
    if (joint.velocity_limit) u.velocity = uniform(-*joint.velocity_limit, *joint.velocity_limit);
    if (joint.effort_limit) u.effort = uniform(-*joint.effort_limit, *joint.effort_limit);
  }
  const Coupling to_encoders = model.transmission.coupling.inverse();
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const Eigen::RowVectorXd weights = to_encoders.row(i);
    Usage u = usage.joints[i];
    u.position = combined(weights, usage.joints, &Usage::position);
    u.velocity = combined(weights, usage.joints, &Usage::velocity);
    usage.encoders.push_back(std::move(u));
  }
  return usage;
}

std::vector<EffectShare> effect_shares(const OperationalModel& model, const std::vector<Effect>& effects,
                                       const RobotUsage& usage) {
  std::vector<EffectShare> shares;
  for (const Effect& e : effects) shares.push_back({e, independent_index(model.chain, e.joint), {}, false});
  const auto n = std::ssize(model.transmission.encoders);
  // Worst case so far, and the white part of it.
  Eigen::MatrixX2d at_joints = Eigen::MatrixX2d::Zero(n, 2), at_encoders = at_joints;
  for (int stage = 0; stage <= static_cast<int>(Stage::kinematics); ++stage) {
    const auto current = static_cast<Stage>(stage);
    if (current == Stage::disc) {
      at_encoders = model.transmission.coupling.inverse().magnitudes().dense() * at_joints;
      // The zero is anywhere within a count; along a motion `change_with_zero` has what that changes.
      for (std::size_t i = 0; i < usage.encoders.size(); ++i)
        if (!usage.encoders[i].duration)
          at_encoders.row(i).array() +=
              0.5 * model.transmission.encoders[i].resolution;  // it adds nothing to sigma
    }
    Eigen::MatrixX2d& before = at_joint(current) ? at_joints : at_encoders;
    for (EffectShare& s : shares) {
      const EffectKind& kind = effect_kind(s.effect.type);
      if (kind.stage != current) continue;
      const Usage& u = at_joint(current) ? usage.joints[s.joint] : usage.encoders[s.joint];
      const auto row = static_cast<Eigen::Index>(s.joint);
      const Encoder& encoder = model.transmission.encoders[s.joint];
      s.share = kind.share(s.effect, encoder, widened(u, before(row, 0), before(row, 1)));
      s.included = s.share && acts_on_robot(kind);
      if (s.share && s.share->step_at_reversal > 0 && !u.duration && u.position && u.velocity &&
          u.position->half_width() > 0)
        s.reversals = 0.5 * u.velocity->largest() / (2 * u.position->half_width());
      if (!s.included || current == Stage::kinematics) continue;
      before(row, 0) += worst(*s.share);
      if (s.share->spectrum != Spectrum::white) continue;
      before(row, 1) += worst(*s.share);
      s.multiplied = std::abs(multiplied_behind(current, s.effect.joint, effects, encoder));
    }
  }
  return shares;
}

std::vector<IndependentError> error_sources(const OperationalModel& model,
                                            const std::vector<EffectShare>& shares,
                                            const std::vector<Norms>& norms,
                                            const std::vector<double>& step_energies) {
  std::vector<IndependentError> sources;
  for (const EffectShare& s : shares) {
    if (!s.included || is_zero(*s.share)) continue;
    const Stage stage = effect_kind(s.effect.type).stage;
    IndependentError source{
        at_joint(stage) ? IndependentError::Where::joint : IndependentError::Where::encoder, s.joint};
    if (stage == Stage::kinematics) {
      const auto link = find_joint(model.chain, s.effect.joint);
      if (!link) continue;  // a mimicked joint outside the chain: its origin does not displace the tip
      source.where = IndependentError::Where::origin;
      const OriginPlace place = origin_place(model.chain, *link);
      source.link = place.link;
      source.direction = place.axes * displacement_direction(s.effect);
    }
    source.mean = s.share->mean;
    source.half_width = s.share->half_width;
    source.sigma = s.multiplied * s.share->sigma;
    for (std::size_t f = 0; f < norms.size(); ++f)
      source.sigma_ratios.push_back(sigma_ratio(
          s, norms[f], f < step_energies.size() ? std::optional(step_energies[f]) : std::nullopt));
    if (model.control && s.share->spectrum != Spectrum::white)  // not known in the joints' loops
      source.loop_ratios.assign(model.control->joints.size(), {NAN, NAN});
    sources.push_back(std::move(source));
  }
  return sources;
}

std::vector<IndependentError> independent_errors(const Transmission& t,
                                                 const std::vector<IndependentError>& others) {
  std::vector<IndependentError> errors;
  for (const Encoder& encoder : t.encoders)
    errors.push_back({.where = IndependentError::Where::encoder,
                      .owner = errors.size(),
                      .mean = mean_error(encoder),
                      .half_width = 0.5 * encoder.resolution,
                      .sigma = encoder.resolution / std::sqrt(12.0),
                      .in_counts = true});
  errors.insert(errors.end(), others.begin(), others.end());
  return errors;
}

Eigen::VectorXd moved_joints(const Transmission& t, const IndependentError& e) {
  const auto i = static_cast<Eigen::Index>(e.owner);
  if (e.where == IndependentError::Where::encoder) return t.coupling.col(i);
  return Eigen::VectorXd::Unit(std::ssize(t.encoders), i);
}

std::vector<IndependentError> accuracy_sources(const std::vector<Encoder>& encoders,
                                               const std::vector<SigmaRatios>& of_encoders,
                                               const std::vector<SigmaRatios>& of_gears) {
  std::vector<IndependentError> sources;
  const auto add = [&](std::size_t encoder, double bound, const std::vector<SigmaRatios>& ratios) {
    if (!(bound > 0)) return;
    IndependentError source{IndependentError::Where::encoder, encoder};
    source.half_width = bound;
    source.sigma = bound / std::numbers::sqrt2;
    source.sigma_ratios = ratios[encoder].filters;
    source.loop_ratios = ratios[encoder].loops;
    sources.push_back(std::move(source));
  };
  for (std::size_t i = 0; i < encoders.size(); ++i) {
    add(i, encoders[i].accuracy, of_encoders);
    add(i, encoders[i].gear_accuracy, of_gears);
  }
  return sources;
}

bool sigma_is_known(const std::vector<IndependentError>& sources, std::size_t filter) {
  return std::ranges::none_of(sources, [&](const IndependentError& s) {
    return filter < s.sigma_ratios.size() && std::isnan(s.sigma_ratios[filter]);
  });
}

Eigen::VectorXd sigma_ratios(const std::vector<IndependentError>& sources, std::size_t filter, double h2,
                             bool beside_noise_in_motion) {
  Eigen::VectorXd ratios = Eigen::VectorXd::Constant(std::ssize(sources), h2);
  for (std::size_t s = 0; s < sources.size(); ++s) {
    double& ratio = ratios[s];
    if (filter < sources[s].sigma_ratios.size()) ratio = sources[s].sigma_ratios[filter];
    if (std::isnan(ratio) || (beside_noise_in_motion && sources[s].in_counts)) ratio = 0;
  }
  return ratios;
}

JointError joint_error(const Transmission& t, const std::vector<IndependentError>& sources,
                       const SignalMoments* along_motion) {
  const auto n = std::ssize(t.encoders);
  JointError e{Eigen::VectorXd::Zero(n), Eigen::VectorXd::Zero(n), {}, {}};
  Eigen::VectorXd variance = Eigen::VectorXd::Zero(n);
  for (const IndependentError& error : independent_errors(t, sources)) {
    if (error.where == IndependentError::Where::origin) continue;
    const Eigen::VectorXd column = moved_joints(t, error);
    e.mean += column * error.mean;
    e.half_width += column.cwiseAbs() * error.half_width;
    variance += (column * error.sigma).cwiseAbs2();
  }
  if (along_motion) {
    e.half_width += along_motion->peak;
    variance += along_motion->covariance.diagonal();
  }
  e.sigma = variance.cwiseSqrt();
  e.worst_case = e.half_width + e.mean.cwiseAbs();
  return e;
}

}  // namespace qerr
