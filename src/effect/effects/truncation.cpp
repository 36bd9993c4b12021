#include "effect/effects/effects.hpp"

namespace qerr {

EffectKind truncation_effect() {
  return {
      .name = "truncation",
      .summary = "the counter rounds down where the model rounds to nearest",
      .typical = "half a count, always downwards; indistinguishable from an offset without an absolute datum",
      .stage = Stage::comparator,
      // Effects within a line must meet the displaced edges, so that the encoder itself is changed instead.
      .action = [](const Effect&, const Encoder&, std::uint64_t) -> Action {
        return [](double x, const Moment&) { return x; };
      },
      .share = [](const Effect&, const Encoder& encoder, const Usage&) -> std::optional<Share> {
        return Share{
            encoder.rounding == Rounding::nearest ? -0.5 * direction(encoder) * encoder.resolution : 0.0, 0,
            0};
      },
      .modify_encoder = [](Encoder& encoder) { encoder.rounding = Rounding::down; },
      .remedy = {true, "add half a count to every reading, or write `rounding: down` into the spec"}};
}

}  // namespace qerr
