#include "effect/effects/effects.hpp"

namespace qerr {

EffectKind varying_jacobian_effect() {
  return {
      .name = "varying_jacobian",
      .summary = "the Jacobian changes along the motion",
      .remedy = {false,
                 "not an error of the robot: the paper's formula does not apply here; use `qerr simulate`"},
      .spec_remedy = "omit it: `qerr simulate` includes it"};
}

}  // namespace qerr
