#include "effects.hpp"

namespace qerr {

EffectKind truncation_effect() {
  return {"truncation",
          "the counter rounds down where the model rounds to nearest",
          "half a count, always the same way; not to be told from an offset without a datum",
          Stage::comparator,
          {},
          [](const Effect&, const Encoder& encoder, std::uint64_t) -> Action {
            const double half = encoder.rounding == Rounding::nearest ? 0.5 * encoder.resolution : 0;
            return [half](double x, const Moment&) { return x - half; };
          },
          [](const Effect&, const Encoder& encoder, const Usage&) -> std::optional<Share> {
            return Share{encoder.rounding == Rounding::nearest ? -0.5 * encoder.resolution : 0.0, 0, 0};
          }};
}

}  // namespace qerr
