#include "effect/effects/effects.hpp"

namespace qerr {

EffectKind correlated_joints_effect() {
  return {
      .name = "correlated_joints",
      .summary = "the errors of joints with correlated motions are not independent",
      .remedy = {false,
                 "not an error of the robot: the paper's formula does not apply here; use `qerr simulate`"},
      .spec_remedy = "omit it: `qerr simulate` includes it"};
}

}  // namespace qerr
