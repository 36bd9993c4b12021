#include "effect/effects/effects.hpp"

namespace qerr {

EffectKind truncation_effect() {
  return {"truncation",
          "the counter rounds down where the model rounds to nearest",
          "half a count, always the same way; not to be told from an offset without a datum",
          Stage::comparator,
          {},
          // Effects within a line must see the edges where they are, so the encoder itself is another.
          [](const Effect&, const Encoder&, std::uint64_t) -> Action {
            return [](double x, const Moment&) { return x; };
          },
          [](const Effect&, const Encoder& encoder, const Usage&) -> std::optional<Share> {
            return Share{encoder.rounding == Rounding::nearest ? -0.5 * encoder.resolution : 0.0, 0, 0};
          },
          Need::nothing,
          [](Encoder& encoder) { encoder.rounding = Rounding::down; }};
}

}  // namespace qerr
