#include "report/diagnosis/extended_reading.hpp"

#include <algorithm>

namespace qerr {

namespace {

/// Whether the reading contains the effect's action.
bool acts(const EffectKind& kind) {
  return kind.action && kind.stage != Stage::log && !kind.random() && !kind.replay;
}

/// The path at any time, linear between its rows and constant beyond them.
double at(const Evidence& e, double time) {
  const double* first = e.time.data();
  const double* last = first + e.rows();
  const auto after = std::upper_bound(first, last, time) - first;
  if (after == 0) return e.path[0];
  if (after == e.rows()) return e.path[e.rows() - 1];
  const double span = e.time[after] - e.time[after - 1];
  return e.path[after - 1] + (e.path[after] - e.path[after - 1]) * (time - e.time[after - 1]) / span;
}

}  // namespace

ExtendedReading::ExtendedReading(const std::vector<Effect>& effects, const Encoder& encoder)
    : resolution_(encoder.resolution) {
  for (const EffectKind& kind : effect_kinds())
    for (const Effect& effect : effects)
      if (effect.type == kind.name && acts(kind))
        steps_.push_back({kind.stage, kind.action(effect, encoder, 0)});
  std::stable_sort(steps_.begin(), steps_.end(),
                   [](const Step& a, const Step& b) { return a.stage < b.stage; });
}

double ExtendedReading::sampled_at(double time) const {
  for (const Step& s : steps_)
    if (s.stage == Stage::clock) time = s.action(time, {});
  return time;
}

double ExtendedReading::operator()(double position, const Moment& moment) const {
  for (const Step& s : steps_) {
    if (s.stage == Stage::clock || s.stage == Stage::reference) continue;
    position = s.stage == Stage::decoder ? resolution_ * s.action(position / resolution_, moment)
                                         : s.action(position, moment);
  }
  return position;
}

double ExtendedReading::reference(double position, const Moment& moment) const {
  for (const Step& s : steps_)
    if (s.stage == Stage::reference) position = s.action(position, moment);
  return position;
}

Eigen::ArrayXd explained(const Evidence& e, const std::vector<Effect>& effects) {
  const ExtendedReading reading(effects, e.encoder);
  Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(e.rows());
  for (const Effect& effect : effects)
    if (const auto replay = effect_kind(effect.type).replay) sum += replay(effect, e);
  for (Eigen::Index k = 0; k < e.rows(); ++k) {
    // Without a clock effect the interpolation error of the path must not appear as an effect.
    const double sampled = reading.sampled_at(e.time[k]);
    const double truth = e.ordered && sampled != e.time[k] ? at(e, sampled) : e.path[k];
    const Moment moment{static_cast<std::uint64_t>(k), e.time[k], truth, e.effort.size() ? e.effort[k] : 0,
                        e.temperature.size() ? e.temperature[k] : 0};
    sum[k] += reading(truth, moment) - reading.reference(e.path[k], moment);
  }
  return sum;
}

bool fits_table(const Effect& effect) { return effect_kind(effect.type).table.has_value(); }

}  // namespace qerr
