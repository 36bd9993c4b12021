#include "encoder/kinds/kinds.hpp"

namespace qerr {

EncoderKind resolution_encoder() {
  return {.name = "resolution",
          .summary = "quantization interval at the joint itself",
          .parameters = {{.name = "resolution",
                          .meaning = "interval at the joint, rad (m for a prismatic joint)",
                          .required = true,
                          .least = 0,
                          .open_below = true,
                          .coordinate = true}},
          .example = "resolution: 1 um",
          .resolution_at_joint = [](const EncoderNumbers& n,
                                    const EncoderChoices&) { return n.at("resolution"); },
          .period_remedy = "give periods_per_rev and interpolation_bits"};
}

}  // namespace qerr
