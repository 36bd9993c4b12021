#include <cmath>

#include "effects.hpp"

namespace qerr {

namespace {

/// Into [-modulus/2, modulus/2), as a counter of two's complement does.
double wrapped(double count, double modulus) { return count - modulus * std::floor(count / modulus + 0.5); }

}  // namespace

EffectKind rollover_effect() {
  return {"rollover",
          "the counter wraps",
          "2^16 or 2^32 counts at once",
          Stage::decoder,
          {{.name = "modulus", .meaning = "counts at which it wraps", .required = true, .least = 1}},
          [](const Effect& e, const Encoder&, std::uint64_t) -> Action {
            return [modulus = e.number("modulus")](double x, const Moment&) { return wrapped(x, modulus); };
          },
          [](const Effect& e, const Encoder& encoder, const Usage& u) {
            const double span = e.number("modulus") * encoder.resolution;
            const double turns = std::ceil(std::max(0.0, u.largest_position / span - 0.5));
            return Share{0, turns * span, turns * span / std::sqrt(12.0)};
          }};
}

}  // namespace qerr
