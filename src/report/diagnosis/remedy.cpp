#include <algorithm>
#include <array>

#include "report/diagnosis/diagnosis_writers.hpp"

namespace qerr {

const Remedy* remedy(std::string_view effect) {
  static constexpr std::array<Remedy, 25> rows{{
      {"offset", true, "subtract it, or set the encoder's zero"},
      {"scale", true, "correct the gear ratio or the counts per revolution, or take the look-up table"},
      {"eccentricity", true, "a look-up table over the encoder's angle takes it out (--write-table)"},
      {"transmission_error", true, "a look-up table over its shaft's angle takes it out (--write-table)"},
      {"subdivision_error", true, "adjust offset, gain and phase of the signals, or take the look-up table"},
      {"state_width", true, "count whole lines where that is fine enough, or adjust the channels' phase"},
      {"missed_counts", false,
       "what is lost stays lost: check against an index pulse; look at cable and shield"},
      {"decoding", false, "set the decoding, or the counts per revolution, in the counter or in the spec"},
      {"truncation", true, "add half a count to every reading, or write `rounding: down` into the spec"},
      {"backlash", true,
       "add or take half the gap by the last direction of motion; around reversals nothing helps"},
      {"compliance", true, "take compliance times the model's load from the reading"},
      {"latency", true, "add delay times velocity to the reading, or stamp it when it is taken"},
      {"timing_jitter", false, "stamp the readings when they are taken, and use the stamps"},
      {"clock_drift", false, "discipline one clock by the other"},
      {"noise", false, "nothing to compensate: a filter, or a better sensor"},
      {"drift", true, "let it warm up, or compensate by a temperature sensor"},
      {"rollover", false, "unwrap the counter in its driver, or take a wider one"},
      {"geometry", false, "correct the link in the URDF"},
      {"reference_error", false, "nothing to compensate in the robot: the better sensor errs"},
      {"log_rounding", false, "nothing to compensate in the robot: write the log with more digits"},
      {"controller_droop", false, "no load and no compliance: record a torque that is measured on its own"},
      {"filter_mismatch", false,
       "give the spec the filter that runs in the controller, or the controller the spec's"},
      {"slow_motion", false, "the paper's formula is off here, not the robot: see `qerr simulate`"},
      {"varying_jacobian", false, "the paper's formula is off here, not the robot: see `qerr simulate`"},
      {"correlated_joints", false, "the paper's formula is off here, not the robot: see `qerr simulate`"},
  }};
  const auto* found =
      std::find_if(rows.begin(), rows.end(), [&](const auto& row) { return row.effect == effect; });
  return found == rows.end() ? nullptr : &*found;
}

}  // namespace qerr
