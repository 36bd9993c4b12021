#include "effect/action_path.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "effect/effects/periodic.hpp"

namespace qerr {

namespace {

int place_in_stage(const EffectKind& kind) { return kind.first_in_stage ? 0 : is_periodic(kind) ? 1 : 2; }

}  // namespace

bool acts_before(const EffectKind& a, const EffectKind& b) {
  if (a.stage != b.stage) return a.stage < b.stage;
  if (a.stage == Stage::decoder) return std::less<>()(&a, &b);  // of one list
  return place_in_stage(a) < place_in_stage(b);
}

void ActionPath::add(const EffectKind& kind, Action action) {
  const auto next = std::ranges::upper_bound(steps_, kind, acts_before,
                                             [](const Step& s) -> const EffectKind& { return *s.kind; });
  if (is_periodic(kind) && next != steps_.begin() && is_periodic(*std::prev(next)->kind) &&
      std::prev(next)->kind->stage == kind.stage)
    std::prev(next)->actions.push_back(std::move(action));
  else
    steps_.insert(next, {&kind, {std::move(action)}});
}

double ActionPath::operator()(double signal, const Moment& m) const {
  for (const Step& step : steps_) {
    const double before = signal;
    signal = step.actions.front()(before, m);
    for (std::size_t i = 1; i < step.actions.size(); ++i) signal += step.actions[i](before, m) - before;
  }
  return signal;
}

void add_to_reading(const Effect& e, const Encoder& encoder, LoopReading& r) {
  const EffectKind& kind = effect_kind(e.type);
  if (!acts_on_robot(kind) || !has_size(e)) return;
  if (kind.in_loop) return kind.in_loop(e, encoder, r);
  const double period = kind.table && kind.table->period ? kind.table->period(e, encoder) : 0;
  if (!(period > 0) || !kind.action) return;
  const Action action = kind.action(e, encoder, 0);
  const int samples = 16 * kind.table->points_per_period;
  double least = std::numeric_limits<double>::infinity(), most = -least, steepest = 0, last = 0;
  for (int i = 0; i <= samples; ++i) {
    const double x = period * i / samples, error = action(x, {}) - x;
    least = std::min(least, error);
    most = std::max(most, error);
    if (i > 0) steepest = std::max(steepest, std::abs(error - last));
    last = error;
  }
  r.of_position += 0.5 * (most - least);
  r.slope += steepest * samples / period;
}

double multiplied_behind(Stage stage, const std::string& joint, const std::vector<Effect>& effects,
                         const Encoder& encoder) {
  LoopReading r;
  for (const Effect& e : effects)
    if (const EffectKind& kind = effect_kind(e.type); e.joint == joint && kind.stage > stage && kind.in_loop)
      kind.in_loop(e, encoder, r);
  return r.factor;
}

}  // namespace qerr
