#include "with_effects.hpp"

#include <algorithm>
#include <cmath>

namespace qerr {

namespace {

/// The path at any instant: cubic between its rows, straight beyond its ends.
double position_at(const Evidence& e, double time) {
  const auto next = std::upper_bound(e.time.begin(), e.time.end(), time);
  const auto k = std::clamp<Eigen::Index>(next - e.time.begin() - 1, 0, e.rows() - 1);
  if (next == e.time.begin() || next == e.time.end()) return e.path[k] + e.velocity[k] * (time - e.time[k]);
  const double length = e.time[k + 1] - e.time[k], u = (time - e.time[k]) / length, v = 1 - u;
  return v * v * (1 + 2 * u) * e.path[k] + u * u * (3 - 2 * u) * e.path[k + 1] +
         length * u * v * (v * e.velocity[k] - u * e.velocity[k + 1]);
}

bool by_chance(const Effect& effect) { return effect.type == "noise" || effect.type == "timing_jitter"; }

/// What one effect adds to the signal on its way from joint to count, row by row.
void act(const Evidence& e, const Effect& effect, Eigen::ArrayXd& signal) {
  const Stage stage = effect_kind(effect.type).stage;
  if (effect.type == "backlash") {
    signal += 0.5 * effect.number("gap") * e.side;
    return;
  }
  const Action action = effect_kind(effect.type).action(effect, e.encoder, 0);
  for (Eigen::Index k = 0; k < e.rows(); ++k) {
    const Moment moment{static_cast<std::uint64_t>(k), e.time[k], e.path[k],
                        e.effort.size() > 0 ? e.effort[k] : 0,
                        e.temperature.size() > 0 ? e.temperature[k] : 0};
    if (stage == Stage::clock) {
      signal[k] += position_at(e, action(e.time[k], moment)) - e.path[k];
    } else if (stage == Stage::decoder) {
      const double count = std::round(signal[k] / e.step());
      signal[k] += (action(count, moment) - count) * e.step();
    } else {
      signal[k] = action(signal[k], moment);
    }
  }
}

}  // namespace

Evidence with_effects(Evidence e, const std::vector<Effect>& effects) {
  Eigen::ArrayXd signal = e.path, reference = e.path;
  bool chance = e.chance.size() > 0;
  Eigen::ArrayXd variance = Eigen::ArrayXd::Zero(e.rows());
  if (chance) variance = e.chance.square();
  for (int stage = 0; stage <= static_cast<int>(Stage::reference); ++stage)
    for (const Effect& effect : effects) {
      const Stage here = effect_kind(effect.type).stage;
      if (effect.joint != e.joint || static_cast<int>(here) != stage || here == Stage::log) continue;
      if (!e.ordered && here == Stage::clock) continue;
      if (by_chance(effect)) {
        chance = true;
        const double sigma = effect.number("sigma");
        variance += here == Stage::clock ? Eigen::ArrayXd((sigma * e.velocity).square())
                                         : Eigen::ArrayXd::Constant(e.rows(), sigma * sigma);
        continue;
      }
      act(e, effect, here == Stage::reference ? reference : signal);
    }
  const Eigen::ArrayXd added = signal - reference;
  e.reference += added;
  e.path += added;
  if (chance) e.chance = variance.sqrt();
  return e;
}

}  // namespace qerr
