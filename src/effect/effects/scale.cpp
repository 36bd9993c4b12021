#include "effect/effects/effects.hpp"

namespace qerr {

EffectKind scale_effect() {
  return {"scale",
          "error proportional to the angle: wrong gear ratio or counts per revolution",
          "1e-4 to 1: a belt's pitch, a ratio given in round numbers",
          Stage::disc,
          {{.name = "scale",
            .meaning = "relative error of the angle",
            .required = true,
            .least = -10,
            .most = 10}},
          [](const Effect& e, const Encoder&, std::uint64_t) -> Action {
            return [scale = e.number("scale")](double x, const Moment&) { return x + scale * x; };
          },
          [](const Effect& e, const Encoder&, const Usage& u) {
            return proportional(e.number("scale"), u.position);
          },
          Need::position};
}

}  // namespace qerr
