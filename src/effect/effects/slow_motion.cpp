#include "effect/effects/effects.hpp"

namespace qerr {

EffectKind slow_motion_effect() {
  return {
      .name = "slow_motion",
      .summary = "the error is neither white nor uniform at less than a few counts per sample",
      .remedy = {false,
                 "not an error of the robot: the paper's formula does not apply here; use `qerr simulate`"},
      .spec_remedy = "omit it: `qerr simulate` and sigma in motion include it"};
}

}  // namespace qerr
