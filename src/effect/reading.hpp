#pragma once

#include <string>
#include <vector>

#include "encoder/loop_reading.hpp"
#include "qerr/effect/effect_kind.hpp"

namespace qerr {

/// Adds what an effect of an encoder makes of a reading that closes a loop: by its row's `in_loop`, else of
/// an error that depends on the position alone, of which the row's table has the period, half width and
/// slope. A bounded error otherwise adds nothing.
void add_to_reading(const Effect&, const Encoder&, LoopReading&);

/// By what the effects of a joint behind a stage multiply an error that its encoder's reading has there.
double multiplied_behind(Stage, const std::string& joint, const std::vector<Effect>&, const Encoder&);

}  // namespace qerr
