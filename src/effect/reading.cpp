#include "effect/reading.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace qerr {

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
