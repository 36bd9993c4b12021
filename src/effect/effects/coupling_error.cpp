#include "effect/effects/effects.hpp"

namespace qerr {

/// Found where several joints have a reference: the drive moves one joint with another, `factor` times the
/// angle of the joint `of`.
EffectKind coupling_error_effect() {
  return {.name = "coupling_error",
          .summary = "the encoder follows another joint too, beyond the coupling that the spec has",
          .stage = Stage::link,
          .parameters = {{.name = "factor", .meaning = "of the other joint's angle", .required = true}},
          .remedy = {false, "state the coupling of the transmission in the spec, or correct it"},
          .spec_remedy = "write coupling: [[...], ...]"};
}

}  // namespace qerr
