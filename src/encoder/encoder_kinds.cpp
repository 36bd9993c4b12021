#include <algorithm>
#include <stdexcept>

#include "encoder/kinds/kinds.hpp"
#include "qerr/encoder/encoder.hpp"

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
  const auto found = std::ranges::find_if(kinds, [&](const auto& k) { return k.name == name; });
  if (found == kinds.end()) throw std::out_of_range("no encoder kind '" + std::string(name) + "'");
  return *found;
}

const std::vector<Parameter>& common_encoder_parameters() {
  static const std::vector<Parameter> common{
      key::number("gear_ratio",
                  "encoder revolutions per joint revolution; negative if the directions are opposite")
          .otherwise(1.0)
          .within(-1e9, 1e9)
          .not_zero(),
      key::number("travel_per_rev",
                  "prismatic joints: travel per revolution of screw or pulley, after the gear",
                  dimension::length)
          .above(0)
          .usually_below(1),
      key::choice("rounding", "nearest|down", "rounding of a position to a count"),
      key::choice("zero", "known|free",
                  "free: incremental without index, a constant error is not identifiable"),
      key::coordinate("accuracy",
                      "data sheet's bound on the slow error: an angle of the encoder's shaft, or of the "
                      "joint beside resolution; a length is at the joint")
          .from(0)
          .usually_below(0.01),
      key::coordinate(
          "gear_accuracy",
          "the gear's bound on the slow error (transmission error), at the joint as its data sheet gives it")
          .from(0)
          .usually_below(0.01),
      key::number("max_frequency",
                  "highest frequency of one channel's signal: of lines or signal periods, a quarter of the "
                  "count rate at x4",
                  dimension::frequency)
          .above(0),
      key::number("max_count_rate", "highest rate of counts", dimension::frequency).above(0),
      key::integer("counter_bits",
                   "bits of the counter: at most 2^(bits - 1) counts a sample of the filters are told from "
                   "their opposite")
          .within(2, 64),
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
