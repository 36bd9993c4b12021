#include "qerr/simulate/sensing.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "qerr/core/error.hpp"
#include "qerr/core/quantity.hpp"
#include "qerr/kinematics/inverse_dynamics.hpp"

namespace qerr {

namespace {

double through(std::vector<Action>& actions, double signal, const Moment& moment) {
  for (Action& action : actions) signal = action(signal, moment);
  return signal;
}

}  // namespace

Chain as_built(const Chain& chain, const std::vector<Effect>& effects) {
  Chain built = chain;
  for (const Effect& effect : effects) {
    if (effect_kind(effect.type).stage != Stage::kinematics) continue;
    const auto moved = find_joint(built, effect.joint);
    if (!moved) continue;  // a master beside the chain does not carry the tip
    ChainJoint& joint = built.joints[*moved];
    joint.origin.pretranslate(effect.number("length") * (joint.parent_axes * displacement_direction(effect)));
  }
  return built;
}

bool needs_effort(const std::vector<Effect>& effects) {
  return std::any_of(effects.begin(), effects.end(), [](const Effect& e) {
    return effect_kind(e.type).stage == Stage::link && e.number("compliance") != 0;
  });
}

Sensing::Sensing(const OperationalModel& model, const Motion& motion, const std::vector<Effect>& effects,
                 const Options& options)
    : built_(as_built(model.chain, effects)),
      transmission_(model.transmission),
      path_(motion),
      sample_rate_(motion.sample_rate),
      to_encoders_(model.transmission.coupling.inverse()),
      shift_(model.transmission.coupling * options.displacement),
      actions_(model.transmission.encoders.size()),
      effort_(has_masses(built_) && (options.effort || needs_effort(effects))) {
  for (const Effect& effect : effects)
    if (const auto rebuilt = effect_kind(effect.type).rebuilt)
      rebuilt(transmission_.encoders[independent_index(model.chain, effect.joint)]);
  // By stage, and within a stage in the order of the spec.
  for (int stage = 0; stage < static_cast<int>(Stage::kinematics); ++stage) {
    for (std::size_t i = 0; i < effects.size(); ++i) {
      const EffectKind& kind = effect_kind(effects[i].type);
      if (static_cast<int>(kind.stage) != stage) continue;
      const std::size_t joint = independent_index(model.chain, effects[i].joint);
      Actions& a = actions_[joint];
      auto& list = kind.stage == Stage::clock                               ? a.clock
                   : kind.stage == Stage::link || kind.stage == Stage::gear ? a.motion
                   : kind.stage == Stage::decoder                           ? a.decoder
                   : kind.stage == Stage::log                               ? a.log
                   : kind.stage == Stage::reference                         ? a.reference
                                                                            : a.encoder;
      list.push_back(kind.action(effects[i], transmission_.encoders[joint], options.seed * 64 + i));
    }
  }
  const auto n = static_cast<Eigen::Index>(actions_.size());
  for (Eigen::VectorXd* v :
       {&reading_.joint, &reading_.counts, &reading_.measured, &reading_.logged, &reading_.reference})
    v->resize(n);
}

double Sensing::position(std::size_t joint, double time) const {
  return path_.position(joint, time) + shift_[static_cast<Eigen::Index>(joint)];
}

Eigen::VectorXd Sensing::effort(double time) const {
  const auto n = static_cast<Eigen::Index>(actions_.size());
  Eigen::VectorXd q(n), velocity(n), acceleration(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const JointState state = path_.at(static_cast<std::size_t>(i), time);
    q[i] = state.position + shift_[i];
    velocity[i] = state.velocity;
    acceleration[i] = state.acceleration;
  }
  return inverse_dynamics(built_, q, velocity, acceleration);
}

/// The joint as the shaft of the encoder feels it: at its clock's instant, behind link and gear.
double Sensing::turned(std::size_t joint) {
  const auto row = static_cast<Eigen::Index>(joint);
  Actions& a = actions_[joint];
  Moment moment{reading_.index, reading_.time, reading_.joint[row], effort_ ? reading_.effort[row] : 0, 0};
  if (!a.clock.empty()) {
    const double instant = through(a.clock, reading_.time, moment);
    moment.joint = position(joint, instant);
    if (effort_ && !a.motion.empty()) moment.effort = effort(instant)[row];
  }
  return through(a.motion, moment.joint, moment);
}

double Sensing::count(std::size_t encoder, double shaft) {
  const Encoder& e = transmission_.encoders[encoder];
  Actions& a = actions_[encoder];
  const Moment moment{reading_.index, reading_.time, reading_.joint[static_cast<Eigen::Index>(encoder)], 0,
                      0};
  const double seen = through(a.encoder, shaft, moment);
  const double count = through(a.decoder, std::round(quantize(e, seen) / e.resolution), moment);
  if (!(std::abs(count) <= 0x1p53))
    throw Error({{},
                 "effects",
                 "a count must be a whole number within 2^53",
                 "encoder " + std::to_string(encoder + 1) + " at " + shortest(reading_.time) + " s",
                 "make the effects smaller"});
  return count;
}

Reading& Sensing::read(std::uint64_t index) {
  Reading& r = reading_;
  r.index = index;
  r.time = static_cast<double>(index) / sample_rate_;
  const std::size_t n = actions_.size();
  for (std::size_t i = 0; i < n; ++i) r.joint[static_cast<Eigen::Index>(i)] = position(i, r.time);
  if (effort_) r.effort = effort(r.time);
  r.tip = forward_kinematics(built_, r.joint);
  r.encoder = to_encoders_ * r.joint;
  Eigen::VectorXd shafts(r.joint.size());
  for (std::size_t i = 0; i < n; ++i) shafts[static_cast<Eigen::Index>(i)] = turned(i);
  shafts = to_encoders_ * shafts;
  for (std::size_t i = 0; i < n; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    r.counts[row] = count(i, shafts[row]);
    r.measured[row] = r.counts[row] * transmission_.encoders[i].resolution;
  }
  r.estimate = transmission_.coupling * r.measured;
  for (std::size_t i = 0; i < n; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const Moment moment{index, r.time, r.joint[row], 0, 0};
    r.logged[row] = through(actions_[i].log, r.estimate[row], moment);
    r.reference[row] = through(actions_[i].log, through(actions_[i].reference, r.joint[row], moment), moment);
  }
  return r;
}

}  // namespace qerr
