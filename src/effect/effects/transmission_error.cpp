#include "effect/effects/effects.hpp"
#include "effect/effects/periodic.hpp"

namespace qerr {

EffectKind transmission_error_effect() {
  return {.name = "transmission_error",
          .summary = "periodic error of gear or encoder, `order` periods per revolution of its shaft",
          .typical =
              "harmonic drives 0.5 to 2 arcmin at order 2 of the input (CSF/CSG catalogue); spur gears at "
              "tooth order",
          .stage = Stage::gear,
          .parameters = {periodic_amplitude(),
                         periodic_phase(),
                         {.name = "order",
                          .meaning = "periods per revolution of the shaft",
                          .required = true,
                          .least = 0,
                          .most = 1e6,
                          .open_below = true},
                         periodic_shaft()},
          .action = periodic_action,
          .share = periodic_share,
          .terms =
              [](const RecordSignals& s) {
                return periodic_terms(s, {2, 3, 4, 6, 8}, {2, 3, 4});
              },
          .twins = periodic_twins(),
          .table = periodic_table(),
          .remedy = {true, "a look-up table over its shaft's angle compensates it (--write-table)"}};
}

}  // namespace qerr
