#include <cmath>

#include "effects.hpp"

namespace qerr {

EffectKind decoding_effect() {
  return {
      "decoding",
      "counts read with the wrong decoding or counts per revolution",
      "factors 1/4, 1/2, 2, 4, -1",
      Stage::decoder,
      {{.name = "factor", .meaning = "reading over right reading, such as 0.25, 2, -1", .required = true}},
      [](const Effect& e, const Encoder&, std::uint64_t) -> Action {
        return
            [factor = e.number("factor")](double x, const Moment&) { return std::floor(factor * x + 0.5); };
      },
      [](const Effect& e, const Encoder&, const Usage& u) {
        const double part = std::abs(e.number("factor") - 1);
        return Share{0, part * u.largest_position, part * u.rms_position};
      }};
}

}  // namespace qerr
