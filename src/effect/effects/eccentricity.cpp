#include "effect/effects/effects.hpp"
#include "effect/effects/periodic.hpp"

namespace qerr {

EffectKind eccentricity_effect() {
  return {
      "eccentricity",
      "disc or magnet off centre: one period a revolution of its shaft",
      "412 e/D arcsec for e um off centre on D mm (Numerik Jena RIK-4); magnets on the axis 0.1 to 2.4 deg",
      Stage::disc,
      {periodic_amplitude(),
       periodic_phase(),
       {.name = "order",
        .meaning = "periods per revolution of the shaft",
        .fallback = 1.0,
        .least = 1,
        .most = 1},
       periodic_shaft()},
      periodic_action,
      periodic_share};
}

}  // namespace qerr
