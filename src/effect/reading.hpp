#pragma once

#include "encoder/loop_reading.hpp"
#include "qerr/effect/effect.hpp"

namespace qerr {

/// Adds what an effect of an encoder makes of a reading that closes a loop: by its row's `in_loop`, else of
/// an error that depends on the position alone, of which the row's table has the period, half width and
/// slope. A bounded error otherwise adds nothing.
void add_to_reading(const Effect&, const Encoder&, LoopReading&);

}  // namespace qerr
