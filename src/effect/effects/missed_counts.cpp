#include "effects.hpp"

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
          [](const Effect& e, const Encoder& encoder, const Usage&) {
            return Share{e.number("counts") * encoder.resolution, 0, 0};
          }};
}

}  // namespace qerr
