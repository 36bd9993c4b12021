#include "simulate/sensing.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "kinematics/inverse_dynamics.hpp"
#include "qerr/core/error.hpp"
#include "qerr/core/quantity.hpp"
#include "simulate/kernels.hpp"

namespace qerr {

Chain as_built(const Chain& chain, const std::vector<Effect>& effects) {
  Chain built = chain;
  for (const Effect& effect : effects) {
    if (effect_kind(effect.type).stage != Stage::kinematics) continue;
    const auto moved = find_joint(built, effect.joint);
    if (!moved) continue;  // a mimicked joint outside the chain does not move the tip
    const OriginPlace place = origin_place(built, *moved);
    Eigen::Isometry3d& frame =
        place.link < built.joints.size() ? built.joints[place.link].origin : built.tip_offset;
    frame.pretranslate(effect.number("length") * (place.axes * displacement_direction(effect)));
  }
  return built;
}

bool needs_effort(const std::vector<Effect>& effects) {
  return std::ranges::any_of(
      effects, [](const Effect& e) { return effect_kind(e.type).need == Need::effort && has_size(e); });
}

Sensing::Sensing(const OperationalModel& model, const Motion& motion, const std::vector<Effect>& effects,
                 const Options& options, InstructionSet set)
    : built_(as_built(model.chain, effects)),
      transmission_(model.transmission),
      path_(motion, set),
      to_encoders_(model.transmission.coupling.inverse()),
      shift_(model.transmission.coupling * options.displacement),
      actions_(model.transmission.encoders.size()),
      masses_(has_masses(built_)),
      effort_((masses_ || states_any(motion.table.efforts)) && (options.effort || needs_effort(effects))),
      temperature_(states_any(motion.table.temperatures)),
      rounds_(options.rounds),
      mean_rounding_(mean_errors(model.transmission)),
      set_(set) {
  for (std::size_t e = 0; e < actions_.size(); ++e)
    actions_[e].decoder.sign = direction(transmission_.encoders[e]);
  for (const Effect& effect : effects)
    if (const auto modify = effect_kind(effect.type).modify_encoder)
      modify(transmission_.encoders[independent_index(model.chain, effect.joint)]);
  const auto kind_of = [&](std::size_t i) -> const EffectKind& { return effect_kind(effects[i].type); };
  std::vector<std::size_t> order(effects.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, acts_before, kind_of);
  for (const std::size_t i : order) {
    const EffectKind& kind = kind_of(i);
    if (kind.stage == Stage::kinematics) continue;
    const std::size_t joint = independent_index(model.chain, effects[i].joint);
    Actions& a = actions_[joint];
    if (!rounds_ && kind.random()) {
      if (kind.stage == Stage::comparator)
        a.decoder.noise = std::hypot(a.decoder.noise,
                                     effects[i].number("sigma") / transmission_.encoders[joint].resolution);
      continue;
    }
    Action action = kind.action(effects[i], transmission_.encoders[joint], options.seed * 64 + i);
    if (kind.stage == Stage::decoder) {
      a.decoder.actions.push_back(std::move(action));
      continue;
    }
    ActionPath& list = kind.stage == Stage::clock                               ? a.clock
                       : kind.stage == Stage::link || kind.stage == Stage::gear ? a.motion
                       : kind.stage == Stage::log                               ? a.log
                       : kind.stage == Stage::reference                         ? a.reference
                                                                                : a.encoder;
    list.add(kind, std::move(action));
  }
  shaft_differs_ =
      std::ranges::any_of(actions_, [](const Actions& a) { return !a.clock.empty() || !a.motion.empty(); });
  const std::size_t n = actions_.size();
  for (AlignedNumbers* rows : {&joint_, &counts_, &measured_}) *rows = AlignedNumbers(n * batch_size);
  if (!transmission_.coupling.is_identity())
    for (AlignedNumbers* rows : {&encoder_, &shaft_, &estimate_}) *rows = AlignedNumbers(n * batch_size);
  if (shaft_differs_) shaft_joint_ = AlignedNumbers(n * batch_size);
  if (effort_) efforts_ = AlignedNumbers(n * batch_size);
  const double* const no_effort = nullptr;
  batch_ = {0,
            nullptr,
            joint_.data(),
            encoder_.data(),
            counts_.data(),
            measured_.data(),
            estimate_.data(),
            effort_ ? efforts_.data() : no_effort,
            shift_.data()};
  for (Eigen::VectorXd* v : {&reading_.joint, &reading_.encoder, &reading_.counts, &reading_.measured,
                             &reading_.estimate, &reading_.logged, &reading_.reference})
    v->resize(n);
  if (effort_) reading_.effort.resize(n);
  if (temperature_) reading_.temperature_rise.setZero(n);
}

double Sensing::position(std::size_t joint, double time) const {
  return path_.path().position(joint, time) + shift_[joint];
}

/// As the motion states them; of other joints by the masses, 0 without any.
Eigen::VectorXd Sensing::effort(double time) const {
  const auto n = std::ssize(actions_);
  const std::vector<RecordedSignal>& stated = path_.path().table().efforts;
  Eigen::VectorXd efforts = masses_ ? dynamic_effort(time) : Eigen::VectorXd::Zero(n).eval();
  for (std::size_t i = 0; i < stated.size(); ++i)
    if (stated[i].values.size() > 0) efforts[i] = path_.path().along(stated[i], time);
  return efforts;
}

double Sensing::temperature_rise(std::size_t joint, double time) const {
  const RecordedSignal& recorded = path_.path().table().temperatures[joint];
  return recorded.values.size() > 0 ? path_.path().along(recorded, time) - recorded.values[0] : 0;
}

Eigen::VectorXd Sensing::dynamic_effort(double time) const {
  const auto n = std::ssize(actions_);
  Eigen::VectorXd q(n), velocity(n), acceleration(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const JointState state = path_.path().at(i, time);
    q[i] = state.position + shift_[i];
    velocity[i] = state.velocity;
    acceleration[i] = state.acceleration;
  }
  return inverse_dynamics(built_, q, velocity, acceleration);
}

JointState Sensing::driven(std::size_t joint, double time) const {
  constexpr double half = 0.025;  // [s]: at 1 Hz it changes the acceleration by 0.2 % (convention)
  const MotionPath& path = path_.path();
  JointState state = path.at(joint, time);
  const std::vector<RecordedSignal>& recorded = path.table().efforts;
  if (joint >= recorded.size() || recorded[joint].values.size() == 0) return state;
  const double before = path.position(joint, time - half), after = path.position(joint, time + half);
  state.velocity = (after - before) / (2 * half);
  state.acceleration = (after - 2 * state.position + before) / (half * half);
  return state;
}

Moment Sensing::moment(std::size_t joint, std::size_t i) const {
  const std::size_t k = joint * batch_size + i;
  const double rise = temperature_ ? temperature_rise(joint, batch_.time[i]) : 0;
  const JointState state = effort_ ? driven(joint, batch_.time[i]) : JointState{};
  return {batch_.first + i, batch_.time[i],    joint_[k], effort_ ? efforts_[k] : 0, rise,
          state.velocity,   state.acceleration};
}

/// The joint position that reaches the encoder shaft: at the instant of its clock, after link and gear.
double Sensing::shaft_position(std::size_t joint, std::size_t i) {
  Actions& a = actions_[joint];
  Moment m = moment(joint, i);
  if (!a.clock.empty()) {
    const double instant = a.clock(m.time, m);
    m.time = instant;
    m.joint = position(joint, instant);
    if (effort_ && !a.motion.empty()) {
      const JointState state = driven(joint, instant);
      m.effort = effort(instant)[joint];
      m.velocity = state.velocity, m.acceleration = state.acceleration;
    }
  }
  return a.motion(m.joint, m);
}

void Sensing::fail_to_count(std::size_t encoder, std::size_t i) const {
  throw Error("effects", "a count must be an integer within 2^53",
              "encoder " + std::to_string(encoder + 1) + " at " + shortest(batch_.time[i]) + " s",
              "reduce the effects");
}

double Sensing::count_of(std::size_t encoder, double position) const {
  const Encoder& e = transmission_.encoders[encoder];
  if (rounds_) return std::round(quantize(e, position) / e.resolution);
  return (position + mean_error(e) - mean_rounding_[encoder]) / e.resolution;
}

double Sensing::count(std::size_t encoder, double shaft, std::size_t i) {
  Actions& a = actions_[encoder];
  Moment m = moment(encoder, i);
  m.effort = 0;
  const double distorted = a.encoder(shaft, m);
  double count = count_of(encoder, distorted);
  if (!a.decoder.empty()) count = a.decoder.mean(count, m);
  if (!(std::abs(count) <= 0x1p53)) fail_to_count(encoder, i);
  return count;
}

/// The rows multiplied by a matrix; the rows themselves if the transmission is not coupled.
const double* Sensing::mixed(const Coupling& c, const AlignedNumbers& from, const AlignedNumbers& to) const {
  if (c.is_identity()) return from.data();
  const Eigen::MatrixXd by_row = c.dense().transpose();
  select_kernels<SimulationKernels>(set_).mix(actions_.size(), by_row.data(), from.data(), to.data());
  return to.data();
}

const double* Sensing::shaft_positions(std::size_t count) {
  for (std::size_t joint = 0; joint < actions_.size(); ++joint) {
    const Actions& a = actions_[joint];
    const bool unchanged = a.clock.empty() && a.motion.empty();
    for (std::size_t i = 0; i < count; ++i)
      shaft_joint_[joint * batch_size + i] =
          unchanged ? joint_[joint * batch_size + i] : shaft_position(joint, i);
  }
  return mixed(to_encoders_, shaft_joint_, shaft_);
}

void Sensing::count_shaft(std::size_t encoder, const double* shaft, std::size_t count) {
  const Encoder& e = transmission_.encoders[encoder];
  const Actions& a = actions_[encoder];
  double* const counts = counts_.data() + encoder * batch_size;
  double* const measured = measured_.data() + encoder * batch_size;
  if (rounds_ && a.encoder.empty() && a.decoder.empty() && below_reading(e) < 1) {
    const Quantizer quantizer{e.resolution, e.rounding == Rounding::down};
    if (select_kernels<SimulationKernels>(set_).quantize(quantizer, shaft, counts, measured)) return;
  }
  for (std::size_t i = 0; i < count; ++i) {
    counts[i] = this->count(encoder, shaft[i], i);
    measured[i] = counts[i] * e.resolution;
  }
}

/// Fills a batch after the end of the motion, where effects and efforts are not evaluated.
void Sensing::repeat_last(const AlignedNumbers& rows, std::size_t count) {
  for (std::size_t row = 0; row < rows.size(); row += batch_size)
    std::fill_n(rows.data() + row + count, batch_size - count, rows[row + count - 1]);
}

const SensedBatch& Sensing::sense(std::uint64_t first, std::size_t count) {
  path_.at(first, count);
  return sense(path_);
}

const SensedBatch& Sensing::sense(const PathBatch& path) {
  batch_.first = path.first();
  batch_.time = path.time();
  const std::size_t n = actions_.size(), count = path.count();
  const SimulationKernels& kernels = select_kernels<SimulationKernels>(set_);
  for (std::size_t joint = 0; joint < n; ++joint)
    kernels.displace(path.joints() + joint * batch_size, shift_[joint], joint_.data() + joint * batch_size);
  for (std::size_t i = 0; effort_ && i < count; ++i) {
    const Eigen::VectorXd efforts = effort(path.time()[i]);
    for (std::size_t joint = 0; joint < n; ++joint) efforts_[joint * batch_size + i] = efforts[joint];
  }
  batch_.encoder = mixed(to_encoders_, joint_, encoder_);
  const double* const shafts = shaft_differs_ ? shaft_positions(count) : batch_.encoder;
  for (std::size_t e = 0; e < n; ++e) count_shaft(e, shafts + e * batch_size, count);
  if (count < batch_size)
    for (const AlignedNumbers* rows : {&counts_, &measured_, &efforts_}) repeat_last(*rows, count);
  batch_.estimate = mixed(transmission_.coupling, measured_, estimate_);
  return batch_;
}

Reading& Sensing::reading(std::size_t i) {
  Reading& r = reading_;
  r.index = batch_.first + i;
  r.time = batch_.time[i];
  for (std::size_t j = 0; j < actions_.size(); ++j) {
    const std::size_t k = j * batch_size + i;
    r.joint[j] = joint_[k];
    r.encoder[j] = batch_.encoder[k];
    r.counts[j] = direction(transmission_.encoders[j]) * counts_[k];
    r.measured[j] = measured_[k];
    r.estimate[j] = batch_.estimate[k];
    if (effort_) r.effort[j] = efforts_[k];
    Moment m = moment(j, i);
    if (temperature_) r.temperature_rise[j] = m.temperature_rise;
    m.effort = 0;
    r.logged[j] = actions_[j].log(r.estimate[j], m);
    r.reference[j] = actions_[j].log(actions_[j].reference(r.joint[j], m), m);
  }
  r.tip = tracked_tip(built_, r.joint);
  return r;
}

Reading& Sensing::read(std::uint64_t index) {
  if (index % batch_size == 0) sense(index);
  return reading(index % batch_size);
}

}  // namespace qerr
