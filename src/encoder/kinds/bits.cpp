#include <cmath>

#include "encoder/kinds/kinds.hpp"

namespace qerr {

EncoderKind bits_encoder() {
  return {.name = "bits",
          .summary = "absolute encoder: bits per revolution",
          .parameters = {key::integer("bits", "bits per encoder revolution").within(1, 40).needed()},
          .example = "bits: 17",
          .counts_per_rev = [](const EncoderNumbers& n,
                               const EncoderChoices&) { return std::exp2(n.at("bits")); },
          .absolute_within = AbsoluteRange::revolution,
          .period_remedy = "give periods_per_rev and interpolation_bits"};
}

}  // namespace qerr
