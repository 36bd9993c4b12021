#pragma once

#include <vector>

#include "diagnose/record/evidence.hpp"
#include "qerr/effect/effect.hpp"

namespace qerr {

/// The evidence for a model that already has effects: reference and path displaced by what they add.
///
/// Every effect's action (`EffectKind`) runs along the path, stage by stage as in a simulation: clocks read
/// the path at their instant, an effect with a `replay` uses the recorded signals, a decoder acts on whole
/// counts, and an error of the reference is subtracted. Random effects only increase `random_sigma`. Effects
/// of the load need the effort column.
Evidence with_effects(Evidence, const std::vector<Effect>&);

/// The rows whose clocks, by these effects, read the path within the record: what it was before and behind is
/// not known.
Evidence within_record(Evidence, const std::vector<Effect>&);

/// The joint's path where the clocks of its encoder read it: what drives a play at the joint [rad or m].
Eigen::ArrayXd path_as_read(const Evidence&, const std::vector<Effect>& clocks);

/// Adds to encoders that depend on several joints (coupling) what the other joints' clocks, links and gears
/// add.
void add_coupled_effects(std::vector<Evidence>&, const Transmission&, const std::vector<Effect>&);

}  // namespace qerr
