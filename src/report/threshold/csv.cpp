#include "report/csv_text.hpp"
#include "report/formats.hpp"

namespace qerr {

std::string to_csv(const ThresholdReport& report, const Style&) {
  std::string out =
      "robot,counts_per_rev,gear_ratio,length_mm,sample_rate_hz,resolution_mm,threshold_velocity_mm_s,"
      "resolution_mm_as_printed,threshold_velocity_mm_s_as_printed\r\n";
  for (const ThresholdRow& r : report.rows) {
    out += csv_cell(r.robot);
    for (const double value : {r.counts_per_rev, r.gear_ratio, 1e3 * r.length, r.sample_rate,
                               1e3 * r.resolution, 1e3 * r.threshold_velocity(),
                               1e3 * r.resolution_as_printed, 1e3 * r.threshold_velocity_as_printed()})
      out += ',' + csv_number(value);
    out += "\r\n";
  }
  return out;
}

}  // namespace qerr
