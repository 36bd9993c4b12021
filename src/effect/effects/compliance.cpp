#include "effect/effects/effects.hpp"

namespace qerr {

EffectKind compliance_effect() {
  return {"compliance",
          "wind-up of gear and link under load",
          "0.1 to 3 mrad at rated load",
          Stage::link,
          {{.name = "compliance",
            .dimension = dimension::compliance,
            .meaning = "angle per torque",
            .required = true,
            .least = 0}},
          [](const Effect& e, const Encoder&, std::uint64_t) -> Action {
            return [c = e.number("compliance")](double x, const Moment& m) { return x + c * m.effort; };
          },
          [](const Effect& e, const Encoder&, const Usage& u) {
            return proportional(e.number("compliance"), u.effort);
          },
          Need::effort};
}

}  // namespace qerr
