#include "effect/effects/effects.hpp"

namespace qerr {

EffectKind geometry_effect() {
  return {"geometry",
          "link dimension differs from the URDF",
          "0.1 to 1 mm before calibration",
          Stage::kinematics,
          {{.name = "axis",
            .kind = Kind::choice,
            .meaning = "direction in the frame before the joint",
            .choices = "x|y|z"},
           {.name = "length",
            .dimension = dimension::length,
            .meaning = "added to the joint's origin",
            .required = true}},
          nullptr,
          [](const Effect& e, const Encoder&, const Usage&) -> std::optional<Share> {
            // The model believes the joint where it is not: estimate - true is against the displacement.
            return Share{0.0 - e.number("length"), 0, 0};
          }};
}

}  // namespace qerr
