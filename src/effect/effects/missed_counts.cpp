#include <cmath>

#include "effect/effects/effects.hpp"

namespace qerr {

EffectKind missed_counts_effect() {
  return {"missed_counts",
          "counts lost or gained at one moment, never to return",
          "one line (4 counts) per burst of interference",
          Stage::decoder,
          {{.name = "counts",
            .kind = Kind::integer,
            .meaning = "counts added to the reading",
            .required = true,
            .least = -1e9,
            .most = 1e9},
           {.name = "time", .dimension = dimension::time, .meaning = "when", .required = true, .least = 0}},
          [](const Effect& e, const Encoder&, std::uint64_t) -> Action {
            return [counts = e.number("counts"), time = e.number("time")](double x, const Moment& m) {
              return m.time >= time ? x + counts : x;
            };
          },
          [](const Effect& e, const Encoder& encoder, const Usage&) -> std::optional<Share> {
            // Nothing before, all after: half of it about half of it, whenever that is.
            const double middle = 0.5 * e.number("counts") * encoder.resolution;
            return Share{middle, std::abs(middle), std::abs(middle)};
          }};
}

}  // namespace qerr
