#include "qerr/encoder/encoder_kinds.hpp"

#include <algorithm>
#include <stdexcept>

#include "encoder/kinds/kinds.hpp"

namespace qerr {

const std::vector<EncoderKind>& encoder_kinds() {
  static const std::vector<EncoderKind> kinds{
      counts_per_rev_encoder(),  lines_per_rev_encoder(), bits_encoder(),
      periods_per_rev_encoder(), resolution_encoder(),
  };
  return kinds;
}

const EncoderKind& encoder_kind(std::string_view name) {
  const auto& kinds = encoder_kinds();
  const auto found = std::find_if(kinds.begin(), kinds.end(), [&](const auto& k) { return k.name == name; });
  if (found == kinds.end()) throw std::out_of_range("no encoder kind '" + std::string(name) + "'");
  return *found;
}

const std::vector<Parameter>& common_encoder_parameters() {
  static const std::vector<Parameter> common{
      {.name = "gear_ratio",
       .meaning = "encoder revolutions per joint revolution; negative if the directions are opposite",
       .fallback = 1.0,
       .least = -1e9,
       .most = 1e9,
       .nonzero = true},
      {.name = "travel_per_rev",
       .dimension = dimension::length,
       .meaning = "prismatic joints: travel per revolution of screw or pulley, after the gear",
       .least = 0,
       .open_below = true,
       .usual = 1},
      {.name = "rounding",
       .kind = Kind::choice,
       .meaning = "rounding of a position to a count",
       .choices = "nearest|down"},
      {.name = "zero",
       .kind = Kind::choice,
       .meaning = "free: incremental without index, a constant error is not identifiable",
       .choices = "known|free"},
      {.name = "accuracy",
       .meaning = "data sheet's bound on the slow error: an angle of the encoder's shaft, or of the joint "
                  "beside resolution; a length is at the joint",
       .least = 0,
       .coordinate = true,
       .usual = 0.01},
      {.name = "gear_accuracy",
       .meaning = "the gear's bound on the slow error (transmission error), at the joint as its data sheet "
                  "gives it",
       .least = 0,
       .coordinate = true,
       .usual = 0.01},
      {.name = "max_frequency",
       .dimension = dimension::frequency,
       .meaning = "highest frequency of one channel's signal: of lines or signal periods, a quarter of the "
                  "count rate at x4",
       .least = 0,
       .open_below = true},
      {.name = "max_count_rate",
       .dimension = dimension::frequency,
       .meaning = "highest rate of counts",
       .least = 0,
       .open_below = true},
      {.name = "counter_bits",
       .kind = Kind::integer,
       .meaning = "bits of the counter: at most 2^(bits - 1) counts a sample of the filters are told from "
                  "their opposite",
       .least = 2,
       .most = 64},
  };
  return common;
}

std::vector<Parameter> encoder_parameters(const EncoderKind& kind) {
  std::vector<Parameter> rows = kind.parameters;
  for (const Parameter& p : common_encoder_parameters())
    if (kind.counts_per_rev ||
        (p.name != "gear_ratio" && p.name != "travel_per_rev" && p.name != "gear_accuracy"))
      rows.push_back(p);
  return rows;
}

}  // namespace qerr
