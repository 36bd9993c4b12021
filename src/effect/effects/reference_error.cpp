#include <cmath>

#include "effect/effects/effects.hpp"
#include "effect/effects/periodic.hpp"

namespace qerr {

EffectKind reference_error_effect() {
  return {"reference_error",
          "the better sensor is at fault: an order of its own machine",
          "steppers used as reference: 0.003 to 0.14 deg at orders 50 and 100",
          Stage::reference,
          {periodic_amplitude(),
           periodic_phase(),
           {.name = "order",
            .meaning = "periods per joint revolution",
            .required = true,
            .least = 0,
            .open_below = true}},
          [](const Effect& e, const Encoder&, std::uint64_t) -> Action {
            return [amplitude = e.number("amplitude"), phase = e.number("phase"), order = e.number("order")](
                       double x, const Moment&) { return x + amplitude * std::sin(order * x + phase); };
          },
          [](const Effect&, const Encoder&, const Usage&) -> std::optional<Share> { return Share{}; }};
}

}  // namespace qerr
