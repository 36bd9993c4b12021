#include "encoder/kinds/kinds.hpp"

namespace qerr {

EncoderKind counts_per_rev_encoder() {
  return {.name = "counts_per_rev",
          .summary = "counts per revolution of the encoder's shaft, after decoding (need not be whole)",
          .parameters = {{.name = "counts_per_rev",
                          .meaning = "counts per encoder revolution, after decoding",
                          .required = true,
                          .least = 0,
                          .most = most_per_revolution,
                          .open_below = true}},
          .example = "counts_per_rev: 4096, gear_ratio: 100",
          .counts_per_rev = [](const EncoderNumbers& n, const EncoderChoices&) {
            return n.at("counts_per_rev");
          }};
}

}  // namespace qerr
