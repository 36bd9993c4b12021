#include "qerr/encoder/encoder_kinds.hpp"

#include <cmath>

namespace qerr {

namespace {

using Numbers = std::map<std::string, double>;
using Choices = std::map<std::string, std::string>;

constexpr double most_counts = 1e15;

double counts(const Numbers& n, const Choices&) { return n.at("counts_per_rev"); }

double edges_per_line(const Numbers&, const Choices& c) {
  const std::string& decoding = c.at("decoding");
  return decoding == "x1" ? 1 : decoding == "x2" ? 2 : 4;
}

double lines(const Numbers& n, const Choices& c) { return n.at("lines_per_rev") * edges_per_line(n, c); }

double bits(const Numbers& n, const Choices&) { return std::exp2(n.at("bits")); }

double steps_per_period(const Numbers& n, const Choices&) { return std::exp2(n.at("interpolation_bits")); }

double periods(const Numbers& n, const Choices& c) {
  return n.at("periods_per_rev") * steps_per_period(n, c);
}

}  // namespace

const std::vector<EncoderKind>& encoder_kinds() {
  static const std::vector<EncoderKind> kinds{
      {"counts_per_rev",
       "counts per revolution of the encoder's shaft, after decoding (need not be whole)",
       {{.name = "counts_per_rev",
         .meaning = "counts per encoder revolution, after decoding",
         .required = true,
         .least = 0,
         .most = most_counts,
         .open_below = true}},
       counts},
      {"lines_per_rev",
       "incremental encoder: lines (slots) per revolution and the decoding of its two channels",
       {{.name = "lines_per_rev",
         .meaning = "lines per encoder revolution",
         .required = true,
         .least = 0,
         .most = most_counts,
         .open_below = true},
        {.name = "decoding",
         .kind = Kind::choice,
         .meaning = "edges counted per line: 1, 2 or 4",
         .choices = "x4|x2|x1"}},
       lines,
       edges_per_line},
      {"bits",
       "absolute encoder: bits per revolution",
       {{.name = "bits",
         .kind = Kind::integer,
         .meaning = "bits per encoder revolution",
         .required = true,
         .least = 1,
         .most = 40}},
       bits},
      {"periods_per_rev",
       "sine/cosine encoder or resolver: signal periods per revolution, interpolated",
       {{.name = "periods_per_rev",
         .meaning = "signal periods per encoder revolution",
         .required = true,
         .least = 0,
         .most = most_counts,
         .open_below = true},
        {.name = "interpolation_bits",
         .kind = Kind::integer,
         .meaning = "bits per signal period",
         .required = true,
         .least = 1,
         .most = 32}},
       periods,
       steps_per_period},
      {"resolution",
       "quantization interval at the joint itself",
       {{.name = "resolution",
         .meaning = "interval at the joint, rad (m for a prismatic joint)",
         .required = true,
         .least = 0,
         .open_below = true,
         .coordinate = true}},
       nullptr},
  };
  return kinds;
}

const std::vector<Parameter>& common_encoder_parameters() {
  static const std::vector<Parameter> common{
      {.name = "gear_ratio",
       .meaning = "encoder revolutions per joint revolution; a negative one is a direction",
       .fallback = 1.0},
      {.name = "travel_per_rev",
       .dimension = dimension::length,
       .meaning = "prismatic joints: travel per revolution of screw or pulley, after the gear",
       .least = 0,
       .open_below = true},
      {.name = "rounding",
       .kind = Kind::choice,
       .meaning = "how a position becomes a count",
       .choices = "nearest|down"},
      {.name = "zero",
       .kind = Kind::choice,
       .meaning = "free: incremental without index, a constant error says nothing",
       .choices = "known|free"},
  };
  return common;
}

}  // namespace qerr
