#pragma once

#include <vector>

#include "diagnose/record/evidence.hpp"
#include "qerr/effect/effect.hpp"

namespace qerr {

/// The evidence as a model sees it that already has effects: reference and path moved to where the encoder
/// then expects to be.
///
/// Every effect's own action (`EffectKind`) runs along the path, stage by stage as in a simulation: clocks
/// read the path at their instant, backlash takes the side of the motion, a decoder acts on whole counts, and
/// an error of the reference is taken off it. Effects by chance (`noise`, `timing_jitter`) only widen
/// `chance`. Compliance needs the effort column.
Evidence with_effects(Evidence, const std::vector<Effect>&);

/// What encoders that turn with several joints (coupling) feel of the others' clocks, links and gears.
void feel(std::vector<Evidence>&, const Transmission&, const std::vector<Effect>&);

}  // namespace qerr
