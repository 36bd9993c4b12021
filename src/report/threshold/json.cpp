#include "report/json_header.hpp"

namespace qerr {

RowsOf<ThresholdRow> rows(Of<ThresholdRow>) {
  return {{"robot", &ThresholdRow::robot},
          {"joint", &ThresholdRow::joint, "with the largest resolution at the tip"},
          {"counts_per_rev", &ThresholdRow::counts_per_rev, nullable},
          {"gear_ratio", &ThresholdRow::gear_ratio, nullable},
          {"coupling", &ThresholdRow::coupling, nullable},
          {"length_mm", [](auto& r) { return 1e3 * r.length; }, nullable},
          {"sample_rate_hz", &ThresholdRow::sample_rate, nullable},
          {"resolution_mm", [](auto& r) { return 1e3 * r.resolution; }, nullable},
          {"threshold_velocity_mm_s", [](auto& r) { return 1e3 * r.threshold_velocity(); }, nullable},
          {"resolution_mm_as_printed", [](auto& r) { return 1e3 * r.resolution_as_printed; }, nullable},
          {"threshold_velocity_mm_s_as_printed",
           [](auto& r) { return 1e3 * r.threshold_velocity_as_printed(); }, nullable}};
}

RowsOf<ThresholdReport> rows(Of<ThresholdReport>) {
  return header<ThresholdReport>("threshold").with({{"robots", &ThresholdReport::rows}});
}

}  // namespace qerr
