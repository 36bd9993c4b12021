#pragma once

#include <cstdint>
#include <optional>

#include "effect/term.hpp"
#include "qerr/effect/effect_kind.hpp"

namespace qerr {

// NAME_effect(): the row of every effect.
#define QERR_EFFECT(name) EffectKind name##_effect();
#include "effect/effects/list.inc"
#undef QERR_EFFECT

/// Bounds of the parameters of effects: an error beyond the range of a joint (1600 turns, or 10 km) [rad or
/// m], and a delay of more than an hour [s], belong to no machine.
inline constexpr double largest_error = 1e4, longest_delay = 3600;

/// Share of an error that is `factor` times a quantity of the motion; empty where the quantity is unknown.
std::optional<Share> proportional(double factor, const std::optional<Spread>&);

/// A standard normal number, a function of (seed, index) alone.
double normal(std::uint64_t seed, std::uint64_t index);

}  // namespace qerr
