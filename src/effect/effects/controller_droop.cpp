#include "effect/effects/effects.hpp"

namespace qerr {

EffectKind controller_droop_effect() {
  return {.name = "controller_droop",
          .summary = "the logged load is proportional to the control error, not to the true load",
          .parameters = {{.name = "gain", .meaning = "logged load over the error"}},
          .remedy = {false, "neither a load nor compliance: record an independently measured torque"},
          .spec_remedy = "omit it; the effect of a true load is compliance"};
}

}  // namespace qerr
