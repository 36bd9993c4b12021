#include "encoder/kinds/kinds.hpp"

namespace qerr {

EncoderKind counts_per_rev_encoder() {
  return {.name = "counts_per_rev",
          .summary = "counts per revolution of the encoder's shaft, after decoding (need not be whole)",
          .parameters = {key::number("counts_per_rev", "counts per encoder revolution, after decoding")
                             .above(0)
                             .up_to(most_per_revolution)
                             .needed()},
          .example = "counts_per_rev: 4096, gear_ratio: 100",
          .counts_per_rev = [](const EncoderNumbers& n, const EncoderChoices&) {
            return n.at("counts_per_rev");
          }};
}

}  // namespace qerr
