#include "encoder/kinds/kinds.hpp"

namespace qerr {

EncoderKind resolution_encoder() {
  return {.name = "resolution",
          .summary = "quantization interval at the joint itself",
          .parameters = {key::coordinate("resolution", "interval at the joint, rad (m for a prismatic joint)")
                             .above(0)
                             .needed()},
          .example = "resolution: 1 um",
          .resolution_at_joint = [](const EncoderNumbers& n,
                                    const EncoderChoices&) { return n.at("resolution"); },
          .period_remedy = "give periods_per_rev and interpolation_bits"};
}

}  // namespace qerr
