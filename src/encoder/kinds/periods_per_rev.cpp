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
          .parameters = {{.name = "periods_per_rev",
                          .meaning = "signal periods per encoder revolution",
                          .required = true,
                          .least = 0,
                          .most = most_per_revolution,
                          .open_below = true},
                         {.name = "interpolation_bits",
                          .kind = Kind::integer,
                          .meaning = "bits per signal period",
                          .required = true,
                          .least = 1,
                          .most = 32}},
          .example = "periods_per_rev: 512, interpolation_bits: 12",
          .counts_per_rev =
              [](const EncoderNumbers& n, const EncoderChoices& c) {
                return n.at("periods_per_rev") * counts_per_period(n, c);
              },
          .counts_per_period = counts_per_period,
          .absolute_within = AbsoluteRange::signal_period};
}

}  // namespace qerr
