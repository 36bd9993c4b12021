#include <cmath>

#include "effect/effects/effects.hpp"
#include "effect/effects/periodic.hpp"

namespace qerr {

EffectKind reference_error_effect() {
  return {
      .name = "reference_error",
      .summary = "periodic error of the reference sensor, `order` periods per joint revolution",
      .typical = "steppers used as reference: 0.003 to 0.14 deg at orders 50 and 100",
      .stage = Stage::reference,
      .parameters = {periodic_amplitude(),
                     periodic_phase(),
                     {.name = "order",
                      .meaning = "periods per joint revolution",
                      .required = true,
                      .least = 0,
                      .most = 1e6,
                      .open_below = true}},
      .action = [](const Effect& e, const Encoder&, std::uint64_t) -> Action {
        return [amplitude = e.number("amplitude"), phase = e.number("phase"), order = e.number("order")](
                   double x, const Moment&) { return x + amplitude * std::sin(order * x + phase); };
      },
      .share = [](const Effect&, const Encoder&, const Usage&) -> std::optional<Share> { return Share{}; },
      .twins = {{"transmission_error", {}, [](const Effect&, const RecordSignals&) { return true; }}},
      .remedy = {false, "nothing to compensate in the robot: the error belongs to the reference sensor"}};
}

}  // namespace qerr
