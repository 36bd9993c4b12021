#include "effect/effects/effects.hpp"

namespace qerr {

EffectKind latency_effect() {
  return {
      "latency",
      "the reading is old",
      "fractions of a sample to 34 ms over a field bus",
      Stage::clock,
      {{.name = "delay", .dimension = dimension::time, .meaning = "age of the reading", .required = true}},
      [](const Effect& e, const Encoder&, std::uint64_t) -> Action {
        return [delay = e.number("delay")](double t, const Moment&) { return t - delay; };
      },
      [](const Effect& e, const Encoder&, const Usage& u) {
        return proportional(-e.number("delay"), u.velocity);
      },
      Need::velocity};
}

}  // namespace qerr
