#include "effect/effects/effects.hpp"
#include "effect/effects/periodic.hpp"

namespace qerr {

namespace {

/// Order 2, of a gear or an elliptic disc, then fits as well as order 1.
bool is_like_higher_orders(const Effect& e, const RecordSignals& s) {
  return periods_covered(e, s) < least_periods;
}

std::vector<Twin> twins() {
  std::vector<Twin> all = periodic_twins();
  all.push_back({"transmission_error", {}, is_like_higher_orders});
  return all;
}

}  // namespace

EffectKind eccentricity_effect() {
  return {.name = "eccentricity",
          .summary = "disc or magnet off centre: one period per revolution of its shaft",
          .typical =
              "412 e/D arcsec for e um off centre on D mm (Numerik Jena RIK-4); magnets on the axis 0.1 to "
              "2.4 deg",
          .stage = Stage::disc,
          .parameters = {periodic_amplitude(),
                         periodic_phase(),
                         {.name = "order",
                          .meaning = "periods per revolution of the shaft",
                          .fallback = 1.0,
                          .least = 1,
                          .most = 1},
                         periodic_shaft()},
          .action = periodic_action,
          .share = periodic_share,
          .terms = [](const RecordSignals& s) { return periodic_terms(s, {1}, {1}); },
          .twins = twins(),
          .record = "several revolutions of the shaft, in both directions",
          .table = periodic_table(),
          .remedy = {true, "a look-up table over the encoder's angle compensates it (--write-table)"}};
}

}  // namespace qerr
