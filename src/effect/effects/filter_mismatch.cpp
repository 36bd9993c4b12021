#include "effect/effects/effects.hpp"

namespace qerr {

EffectKind filter_mismatch_effect() {
  return {
      .name = "filter_mismatch",
      .summary = "the filter of the controller differs from that of the spec",
      .parameters = {{.name = "family", .kind = Kind::choice, .meaning = "of the low-pass found"},
                     {.name = "order", .kind = Kind::integer, .meaning = "of the low-pass"},
                     {.name = "cutoff", .dimension = dimension::frequency, .meaning = "of the low-pass"},
                     {.name = "delay", .dimension = dimension::time, .meaning = "beside the low-pass"}},
      .remedy = {false, "give the spec the filter that runs in the controller, or the controller the spec's"},
      .is_filter = true,
      .spec_remedy = "write the controller's filter under filters:"};
}

}  // namespace qerr
