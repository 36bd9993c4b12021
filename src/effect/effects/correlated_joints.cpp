#include "effect/effects/effects.hpp"

namespace qerr {

EffectKind correlated_joints_effect() {
  return {
      .name = "correlated_joints",
      .summary = "the errors of joints with correlated motions are not independent",
      .remedy = {false,
                 "the paper's formula does not apply here; the robot is not at fault: see `qerr simulate`"},
      .spec_remedy = "leave it out; `qerr simulate` includes it"};
}

}  // namespace qerr
