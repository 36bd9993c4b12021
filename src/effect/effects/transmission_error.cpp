#include "effect/effects/effects.hpp"
#include "effect/effects/periodic.hpp"

namespace qerr {

EffectKind transmission_error_effect() {
  return {"transmission_error",
          "periodic error of gear or encoder, `order` periods a revolution of its shaft",
          "harmonic drives 0.5 to 2 arcmin at order 2 of the input (CSF/CSG catalogue); spur gears at tooth "
          "order",
          Stage::gear,
          {periodic_amplitude(),
           periodic_phase(),
           {.name = "order",
            .meaning = "periods per revolution of the shaft",
            .required = true,
            .least = 0,
            .most = 1e6,
            .open_below = true},
           periodic_shaft()},
          periodic_action,
          periodic_share};
}

}  // namespace qerr
