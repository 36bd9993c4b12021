#pragma once

#include <vector>

#include "qerr/diagnose/evidence.hpp"
#include "qerr/effect/effect.hpp"

namespace qerr {

/// The evidence as a model sees it that already has effects: reference and path moved to where the encoder
/// then expects to be.
///
/// Every effect's own action (`EffectKind`) runs along the path, stage by stage as in a simulation: clocks
/// read the path at their instant, backlash takes the side of the motion, a decoder acts on whole counts, and
/// an error of the reference is taken off it. Effects by chance (`noise`, `timing_jitter`) only widen
/// `chance`. Compliance needs the effort column; an encoder is taken to be its joint's own.
Evidence with_effects(Evidence, const std::vector<Effect>&);

}  // namespace qerr
