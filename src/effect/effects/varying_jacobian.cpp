#include "effect/effects/effects.hpp"

namespace qerr {

EffectKind varying_jacobian_effect() {
  return {
      .name = "varying_jacobian",
      .summary = "the Jacobian changes along the motion",
      .remedy = {false,
                 "the paper's formula does not apply here; the robot is not at fault: see `qerr simulate`"},
      .spec_remedy = "leave it out; `qerr simulate` includes it"};
}

}  // namespace qerr
