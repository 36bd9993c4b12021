#include "diagnose/record/with_effects.hpp"

#include <algorithm>
#include <cmath>

#include "diagnose/record/sampling.hpp"
#include "diagnose/record/smooth_path.hpp"
#include "effect/action_path.hpp"
#include "effect/effects/effects.hpp"
#include "effect/effects/periodic.hpp"
#include "qerr/effect/effect_kind.hpp"

namespace qerr {

bool displaces(const Term& t) {
  if (!t.named() || t.constant) return false;
  const EffectKind& kind = effect_kind(t.effect.type);
  return kind.stage < Stage::gear || kind.first_in_stage;
}

bool displaces(const Term& t, const Term& other) {
  if (!other.named() || !t.named()) return displaces(t);
  const EffectKind &kind = effect_kind(t.effect.type), &next = effect_kind(other.effect.type);
  if (is_periodic(next) && refers_to_joint(other.effect)) return kind.stage == Stage::clock;
  return acts_before(kind, next) || (kind.stage == next.stage && displaces(t) && !next.first_in_stage);
}

namespace {

bool is_random(const Effect& effect) { return effect_kind(effect.type).random(); }

/// The signal from joint to count, row by row, as effects act on it. Borrows the evidence.
struct SignalPath {
  const Evidence& e;
  const Eigen::ArrayXd &path, &velocity;  ///< of what the effect acts on
  Eigen::ArrayXd signal;
  Eigen::ArrayXd before_sines = {};  ///< of a stage: periodic errors add
  Eigen::ArrayXd instants = {};      ///< of the readings: each clock acts on what the one before it says

  void act(const Effect& effect) {
    const EffectKind& kind = effect_kind(effect.type);
    if (effect.type == coupling_error_effect().name) {
      for (const Evidence* other : e.others)
        if (other->joint == effect.choices.at("of")) signal += effect.number("factor") * other->path;
      return;
    }
    if (kind.replay)
      if (const Eigen::ArrayXd added = kind.replay(effect, e); added.size() > 0) {
        signal += added;
        return;
      }
    const Stage stage = kind.stage;
    const bool sine = is_periodic(kind);
    if (sine && before_sines.size() == 0) before_sines = signal;
    if (stage == Stage::clock && instants.size() == 0) instants = e.time;
    const Action action = kind.action(effect, e.encoder, 0);
    Eigen::Index before = 0;  // of a clock's instant
    for (Eigen::Index k = 0; k < e.rows(); ++k) {
      const Moment moment{static_cast<std::uint64_t>(k),
                          e.time[k],
                          path[k],
                          e.effort.size() > 0 ? e.effort[k] : 0,
                          e.temperature.size() > 0 ? e.temperature[k] : 0,
                          velocity[k],
                          e.acceleration.size() > 0 ? e.acceleration[k] : 0};
      if (stage == Stage::clock) {
        instants[k] = action(instants[k], moment);
        signal[k] = position_at(e.time, path, velocity, instants[k], before);
      } else if (stage == Stage::decoder) {
        const double sign = direction(e.encoder), count = sign * std::round(signal[k] / e.step());
        signal[k] += sign * (action(count, moment) - count) * e.step();
      } else if (sine) {
        signal[k] += action(before_sines[k], moment) - before_sines[k];
      } else {
        signal[k] = action(signal[k], moment);
      }
    }
  }

  /// Effects of some stages, in the order in which ActionPath has them.
  void pass(const std::vector<Effect>& effects, Stage first, Stage last) {
    for (int stage = static_cast<int>(first); stage <= static_cast<int>(last); ++stage) {
      std::vector<const Effect*> here;
      for (const Effect& effect : effects) {
        const Stage own = effect_kind(effect.type).stage;
        if (effect.joint != e.joint || static_cast<int>(own) != stage || is_random(effect)) continue;
        if (e.ordered || own != Stage::clock) here.push_back(&effect);
      }
      std::ranges::stable_sort(here, acts_before, [](const Effect* effect) -> const EffectKind& {
        return effect_kind(effect->type);
      });
      before_sines.resize(0);
      for (const Effect* effect : here) act(*effect);
    }
  }
};

/// What clock, link and gear add to a joint.
Eigen::ArrayXd joint_addition(const Evidence& e, const std::vector<Effect>& effects) {
  SignalPath joint{e, e.joint_angle(), e.joint_rate(), e.joint_angle()};
  joint.pass(effects, Stage::clock, Stage::gear);
  return joint.signal - e.joint_angle();
}

void move(Evidence& e, const Eigen::ArrayXd& by) {
  e.reference += by;
  e.path += by;
}

bool is_own_clock(const Evidence& record, const Effect& effect) {
  return effect.joint == record.joint && effect_kind(effect.type).stage == Stage::clock && !is_random(effect);
}

}  // namespace

PathAsRead::PathAsRead(const Evidence& e, const std::vector<Effect>& clocks) : e_(e) {
  for (const Effect& effect : clocks)
    if (e.ordered && is_own_clock(e, effect))
      clocks_.push_back(effect_kind(effect.type).action(effect, e.encoder, 0));
}

double PathAsRead::instant(double time) const {
  double instant = time;
  for (const Action& clock : clocks_) instant = clock(instant, Moment{.time = time});
  return instant;
}

double PathAsRead::operator()(Eigen::Index row) {
  if (clocks_.empty()) return e_.joint_angle()[row];
  return position_at(e_.time, e_.joint_angle(), e_.joint_rate(), instant(e_.time[row]), before_);
}

Eigen::ArrayXd PathAsRead::of_all_rows() {
  Eigen::ArrayXd all(e_.rows());
  for (Eigen::Index k = 0; k < all.size(); ++k) all[k] = (*this)(k);
  return all;
}

Eigen::Array<bool, Eigen::Dynamic, 1> reads_within(const Evidence& record, const std::vector<Effect>& effects,
                                                   const Eigen::ArrayXd& time) {
  const PathAsRead path(record, effects);
  const Eigen::ArrayXd instants = time.unaryExpr([&](double t) { return path.instant(t); });
  return instants >= record.time[0] && instants <= record.time[record.rows() - 1];
}

Evidence within_record(Evidence e, const std::vector<Effect>& effects) {
  const auto is_clock = [&](const Effect& effect) { return is_own_clock(e, effect); };
  if (!e.ordered || std::none_of(effects.begin(), effects.end(), is_clock)) return e;
  const auto within = reads_within(e, effects, e.time);
  std::vector<Eigen::Index> rows;
  for (Eigen::Index k = 0; k < e.rows(); ++k)
    if (within[k]) rows.push_back(k);
  return static_cast<Eigen::Index>(rows.size()) < e.rows() && !rows.empty() ? rows_of(e, rows) : e;
}

Evidence with_effects(Evidence e, const std::vector<Effect>& effects) {
  if (std::none_of(effects.begin(), effects.end(), [&](const Effect& x) { return x.joint == e.joint; }))
    return e;
  SignalPath encoder{e, e.path, e.velocity, e.path + joint_addition(e, effects)};
  encoder.pass(effects, Stage::disc, Stage::decoder);
  SignalPath reference{e, e.joint_angle(), e.joint_rate(), e.joint_angle()};
  reference.pass(effects, Stage::reference, Stage::reference);
  const Eigen::ArrayXd added = encoder.signal - e.path - (reference.signal - e.joint_angle());
  Eigen::ArrayXd variance = Eigen::ArrayXd::Zero(e.rows());
  if (e.random_sigma.size() > 0) variance = e.random_sigma.square();
  for (const Effect& effect : effects)
    if (effect.joint == e.joint && is_random(effect)) {
      const Scattering& scattering = *effect_kind(effect.type).scattering;
      const double size = effect.number(std::string(scattering.parameter));
      if (!scattering.possible || scattering.possible(e))
        variance += (size * scattering.deviation(e)).square();
    }
  move(e, added);
  if ((variance > 0).any()) e.random_sigma = variance.sqrt();
  return e;
}

void add_coupled_effects(std::vector<Evidence>& all, const Transmission& transmission,
                         const std::vector<Effect>& effects) {
  if (effects.empty() || std::none_of(all.begin(), all.end(), [](const Evidence& e) { return e.coupled(); }))
    return;
  const Coupling to_encoders = transmission.coupling.inverse();
  std::vector<Eigen::ArrayXd> added;
  for (const Evidence& e : all) added.push_back(joint_addition(e, effects));
  for (Evidence& e : all)
    for (std::size_t j = 0; j < all.size(); ++j)
      if (all[j].joint != e.joint && to_encoders(e.number, all[j].number) != 0)
        move(e, to_encoders(e.number, all[j].number) * added[j]);
}

}  // namespace qerr
