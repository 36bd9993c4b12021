#include <cmath>

#include "encoder/kinds/kinds.hpp"

namespace qerr {

namespace {

double counts_per_period(const EncoderNumbers& n, const EncoderChoices&) {
  return std::exp2(n.at("interpolation_bits"));
}

}  // namespace

EncoderKind periods_per_rev_encoder() {
  return {.name = "periods_per_rev",
          .summary = "sine/cosine encoder or resolver: signal periods per revolution, interpolated",
          .parameters = {key::number("periods_per_rev", "signal periods per encoder revolution")
                             .above(0)
                             .up_to(most_per_revolution)
                             .needed(),
                         key::integer("interpolation_bits", "bits per signal period").within(1, 32).needed()},
          .example = "periods_per_rev: 512, interpolation_bits: 12",
          .counts_per_rev =
              [](const EncoderNumbers& n, const EncoderChoices& c) {
                return n.at("periods_per_rev") * counts_per_period(n, c);
              },
          .counts_per_period = counts_per_period,
          .absolute_within = AbsoluteRange::signal_period};
}

}  // namespace qerr
