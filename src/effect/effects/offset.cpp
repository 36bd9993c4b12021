#include "effect/effects/effects.hpp"

namespace qerr {

EffectKind offset_effect() {
  return {"offset",
          "constant error: zero or index misplaced",
          "any; fractions of a degree after homing by hand",
          Stage::disc,
          {{.name = "offset", .meaning = "estimate minus true", .required = true, .coordinate = true}},
          [](const Effect& e, const Encoder&, std::uint64_t) -> Action {
            return [offset = e.number("offset")](double x, const Moment&) { return x + offset; };
          },
          [](const Effect& e, const Encoder&, const Usage&) -> std::optional<Share> {
            return Share{e.number("offset"), 0, 0};
          }};
}

}  // namespace qerr
