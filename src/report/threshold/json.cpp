#include "report/formats.hpp"
#include "report/json_value.hpp"

namespace qerr {

std::string to_json(const ThresholdReport& report, const Style&) {
  Json list = Json::array();
  for (const ThresholdRow& r : report.rows)
    list.push_back({{"robot", r.robot},
                    {"joint", r.joint},
                    {"counts_per_rev", r.counts_per_rev},
                    {"gear_ratio", r.gear_ratio},
                    {"coupling", r.coupling},
                    {"length_mm", 1e3 * r.length},
                    {"sample_rate_hz", r.sample_rate},
                    {"resolution_mm", 1e3 * r.resolution},
                    {"threshold_velocity_mm_s", 1e3 * r.threshold_velocity()},
                    {"resolution_mm_as_printed", 1e3 * r.resolution_as_printed},
                    {"threshold_velocity_mm_s_as_printed", 1e3 * r.threshold_velocity_as_printed()}});
  return Json{{"qerr", version()}, {"command", "threshold"}, {"robots", list}}.document();
}

}  // namespace qerr
