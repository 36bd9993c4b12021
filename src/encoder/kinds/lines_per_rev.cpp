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
      .parameters = {{.name = "lines_per_rev",
                      .meaning = "lines per encoder revolution",
                      .required = true,
                      .least = 0,
                      .most = most_per_revolution,
                      .open_below = true},
                     {.name = "decoding",
                      .kind = Kind::choice,
                      .meaning = "edges counted per line: 1, 2 or 4",
                      .choices = "x4|x2|x1"}},
      .example = "lines_per_rev: 1024, decoding: x4",
      .ambiguous_keys = "cpr|ppr|CPR|PPR",
      .ambiguous_remedy =
          "write counts_per_rev (after decoding) or lines_per_rev with decoding: x1, x2 or x4",
      .counts_per_rev = [](const EncoderNumbers& n,
                           const EncoderChoices& c) { return n.at("lines_per_rev") * edges_per_line(n, c); },
      .counts_per_period = edges_per_line};
}

}  // namespace qerr
