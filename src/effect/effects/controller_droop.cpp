#include "effect/effects/effects.hpp"

namespace qerr {

EffectKind controller_droop_effect() {
  return {.name = "controller_droop",
          .summary = "a logged load is a multiple of the error, not a load",
          .parameters = {{.name = "gain", .meaning = "logged load over the error"}},
          .remedy = {false, "no load and no compliance: record a torque that is measured independently"},
          .spec_remedy = "leave it out; a true load is compliance"};
}

}  // namespace qerr
