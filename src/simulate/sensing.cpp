#include "qerr/simulate/sensing.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace qerr {

namespace {

double through(std::vector<Action>& actions, double signal, const Moment& moment) {
  for (Action& action : actions) signal = action(signal, moment);
  return signal;
}

std::size_t index_of(const Chain& chain, const std::string& joint) {
  const auto found = std::find_if(chain.independent.begin(), chain.independent.end(),
                                  [&](const IndependentJoint& j) { return j.name == joint; });
  return static_cast<std::size_t>(found - chain.independent.begin());
}

}  // namespace

Sensing::Sensing(const OperationalModel& model, const Motion& motion, const std::vector<Effect>& effects,
                 const Eigen::VectorXd& displacement, std::uint64_t seed)
    : transmission_(model.transmission),
      path_(motion),
      sample_rate_(motion.sample_rate),
      to_encoders_(model.transmission.coupling.inverse()),
      shift_(model.transmission.coupling * displacement),
      actions_(model.transmission.encoders.size()) {
  // By stage, and within a stage in the order of the spec.
  for (int stage = 0; stage <= static_cast<int>(Stage::reference); ++stage) {
    for (std::size_t i = 0; i < effects.size(); ++i) {
      const EffectKind& kind = effect_kind(effects[i].type);
      if (static_cast<int>(kind.stage) != stage) continue;
      const std::size_t joint = index_of(model.chain, effects[i].joint);
      Actions& a = actions_[joint];
      auto& list = kind.stage == Stage::clock                               ? a.clock
                   : kind.stage == Stage::link || kind.stage == Stage::gear ? a.motion
                   : kind.stage == Stage::decoder                           ? a.decoder
                   : kind.stage == Stage::log                               ? a.log
                   : kind.stage == Stage::reference                         ? a.reference
                                                                            : a.encoder;
      list.push_back(kind.action(effects[i], transmission_.encoders[joint], seed * 64 + i));
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

Reading& Sensing::read(std::uint64_t index) {
  Reading& r = reading_;
  r.index = index;
  r.time = static_cast<double>(index) / sample_rate_;
  const auto n = actions_.size();
  Eigen::VectorXd turned(static_cast<Eigen::Index>(n));  // joints as the shafts of the encoders feel them
  for (std::size_t i = 0; i < n; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    Actions& a = actions_[i];
    Moment moment{index, r.time, 0, 0, 0};
    r.joint[row] = position(i, r.time);
    const double seen = a.clock.empty() ? r.joint[row] : position(i, through(a.clock, r.time, moment));
    moment.joint = seen;
    turned[row] = through(a.motion, seen, moment);
    moment.joint = r.joint[row];
    r.reference[row] = through(a.reference, r.joint[row], moment);
  }
  r.encoder = to_encoders_ * r.joint;
  const Eigen::VectorXd shaft = to_encoders_ * turned;
  for (std::size_t i = 0; i < n; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const Encoder& encoder = transmission_.encoders[i];
    const Moment moment{index, r.time, r.joint[row], 0, 0};
    const double seen = through(actions_[i].encoder, shaft[row], moment);
    const double count = std::round(quantize(encoder, seen) / encoder.resolution);
    r.counts[row] = through(actions_[i].decoder, count, moment);
    r.measured[row] = r.counts[row] * encoder.resolution;
  }
  r.estimate = transmission_.coupling * r.measured;
  for (std::size_t i = 0; i < n; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const Moment moment{index, r.time, r.joint[row], 0, 0};
    r.logged[row] = through(actions_[i].log, r.estimate[row], moment);
    r.reference[row] = through(actions_[i].log, r.reference[row], moment);
  }
  return r;
}

}  // namespace qerr
