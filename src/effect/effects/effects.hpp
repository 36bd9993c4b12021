#pragma once

#include "qerr/effect/effect.hpp"

namespace qerr {

// One line per member of this folder; src/effect/effect.cpp lists them.
EffectKind offset_effect();
EffectKind scale_effect();
EffectKind eccentricity_effect();
EffectKind transmission_error_effect();
EffectKind subdivision_error_effect();
EffectKind state_width_effect();
EffectKind missed_counts_effect();
EffectKind decoding_effect();
EffectKind truncation_effect();
EffectKind backlash_effect();
EffectKind compliance_effect();
EffectKind latency_effect();
EffectKind timing_jitter_effect();
EffectKind clock_drift_effect();
EffectKind noise_effect();
EffectKind drift_effect();
EffectKind rollover_effect();
EffectKind geometry_effect();
EffectKind reference_error_effect();
EffectKind log_rounding_effect();

/// The share of an error that is `factor` times a quantity of the motion; empty where that is not known.
std::optional<Share> proportional(double factor, const std::optional<Spread>&);

/// A standard normal number that depends on (seed, index) alone.
double normal(std::uint64_t seed, std::uint64_t index);

}  // namespace qerr
