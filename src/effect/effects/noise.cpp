#include "effect/effects/effects.hpp"

namespace qerr {

EffectKind noise_effect() {
  return {
      "noise",
      "white noise before the quantizer",
      "0 to 1 count",
      Stage::comparator,
      {{.name = "sigma", .meaning = "standard deviation", .required = true, .least = 0, .coordinate = true}},
      [](const Effect& e, const Encoder&, std::uint64_t seed) -> Action {
        return [sigma = e.number("sigma"), seed](double x, const Moment& m) {
          return sigma == 0 ? x : x + sigma * normal(seed, m.index);
        };
      },
      [](const Effect& e, const Encoder&, const Usage&) -> std::optional<Share> {
        return Share{0, 4 * e.number("sigma"), e.number("sigma"), Course::white};
      }};
}

}  // namespace qerr
