#include "effect/effects/effects.hpp"

namespace qerr {

namespace {

/// The motor leads the joint by half the gap, on the side on which it pushed last; until the first motion it
/// stands in the middle of the gap.
Action action(const Effect& e, const Encoder&, std::uint64_t) {
  return
      [half = 0.5 * e.number("gap"), side = 0.0, last = 0.0, first = true](double x, const Moment&) mutable {
        if (!first && x != last) side = x > last ? 1 : -1;
        first = false;
        last = x;
        return x + side * half;
      };
}

}  // namespace

EffectKind backlash_effect() {
  return {"backlash",
          "play between encoder and joint",
          "1 to 10 arcmin in gears, none in a harmonic drive",
          Stage::gear,
          {{.name = "gap", .meaning = "full width", .required = true, .least = 0, .coordinate = true}},
          action,
          [](const Effect& e, const Encoder&, const Usage&) -> std::optional<Share> {
            const double half = 0.5 * e.number("gap");
            return Share{0, half, half, Course::reversals};
          }};
}

}  // namespace qerr
