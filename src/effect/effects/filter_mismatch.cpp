#include "effect/effects/effects.hpp"

namespace qerr {

EffectKind filter_mismatch_effect() {
  return {
      .name = "filter_mismatch",
      .summary = "the filter of the controller differs from that of the spec",
      .parameters = {{.name = "family", .kind = Kind::choice, .meaning = "of the fitted low-pass"},
                     {.name = "order", .kind = Kind::integer, .meaning = "of the low-pass"},
                     {.name = "cutoff", .dimension = dimension::frequency, .meaning = "of the low-pass"},
                     {.name = "delay",
                      .dimension = dimension::time,
                      .meaning = "additional to the low-pass"}},
      .remedy = {false,
                 "write the controller's filter into the spec, or run the spec's filter in the controller"},
      .is_filter = true,
      .spec_remedy = "write the controller's filter under filters:"};
}

}  // namespace qerr
