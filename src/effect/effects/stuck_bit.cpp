#include <cmath>

#include "effect/effects/effects.hpp"

namespace qerr {

namespace {

/// Of a counter of two's complement.
double with_bit(double count, double span, bool value) {
  const bool present = std::fmod(std::floor(count / span), 2) != 0;
  return present == value ? count : count + (value ? span : -span);
}

/// Half of all readings are off by the bit.
std::optional<Share> share(const Effect& e, const Encoder& encoder, const Usage&) {
  const double half = 0.5 * std::exp2(e.number("bit")) * encoder.resolution;
  const double sign = direction(encoder) * (e.number("value") != 0 ? 1 : -1);
  return Share{sign * half, half, half, Spectrum::motion};
}

}  // namespace

EffectKind stuck_bit_effect() {
  return {
      .name = "stuck_bit",
      .summary = "a bit of the counts never changes",
      .typical = "a broken line of a parallel interface, a mask in a driver",
      .stage = Stage::decoder,
      .parameters = {{.name = "bit",
                      .kind = Kind::integer,
                      .meaning = "its number; bit 0 is worth one count",
                      .required = true,
                      .least = 0,
                      .most = 31},
                     {.name = "value",
                      .kind = Kind::integer,
                      .meaning = "0 or 1",
                      .required = true,
                      .least = 0,
                      .most = 1}},
      .action = [](const Effect& e, const Encoder&, std::uint64_t) -> Action {
        return [span = std::exp2(e.number("bit")), value = e.number("value") != 0](double x, const Moment&) {
          return with_bit(x, span, value);
        };
      },
      .share = share,
      .jumps = true,
      .remedy = {false, "look for a broken line of a parallel or serial interface, or a mask in the driver"}};
}

}  // namespace qerr
