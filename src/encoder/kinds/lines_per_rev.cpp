#include "encoder/kinds/kinds.hpp"

namespace qerr {

namespace {

double edges_per_line(const EncoderNumbers&, const EncoderChoices& c) {
  const std::string& decoding = c.at("decoding");
  return decoding == "x1" ? 1 : decoding == "x2" ? 2 : 4;
}

}  // namespace

EncoderKind lines_per_rev_encoder() {
  return {
      .name = "lines_per_rev",
      .summary = "incremental encoder: lines (slots) per revolution and the decoding of its two channels",
      .parameters = {key::number("lines_per_rev", "lines per encoder revolution")
                         .above(0)
                         .up_to(most_per_revolution)
                         .needed(),
                     key::choice("decoding", "x4|x2|x1", "edges counted per line: 1, 2 or 4")},
      .example = "lines_per_rev: 1024, decoding: x4",
      .ambiguous_keys = "cpr|ppr|CPR|PPR",
      .ambiguous_remedy =
          "write counts_per_rev (after decoding) or lines_per_rev with decoding: x1, x2 or x4",
      .counts_per_rev = [](const EncoderNumbers& n,
                           const EncoderChoices& c) { return n.at("lines_per_rev") * edges_per_line(n, c); },
      .counts_per_period = edges_per_line};
}

}  // namespace qerr
