#include "effect/effects/effects.hpp"

namespace qerr {

EffectKind slow_motion_effect() {
  return {
      .name = "slow_motion",
      .summary = "the error is neither white nor uniform at so few counts a sample",
      .remedy = {false,
                 "the paper's formula does not apply here; the robot is not at fault: see `qerr simulate`"},
      .spec_remedy = "leave it out; `qerr simulate` and sigma in motion include it"};
}

}  // namespace qerr
