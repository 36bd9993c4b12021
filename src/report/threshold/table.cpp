#include "report/fitted_table.hpp"
#include "report/formats.hpp"
#include "report/text_table.hpp"
#include "report/wrapped_text.hpp"

namespace qerr {

namespace {

/// The rows whose coupling is a factor of the resolution.
std::string couplings(const ThresholdReport& report, std::size_t width) {
  std::string out;
  for (const ThresholdRow& r : report.rows)
    if (r.coupling != 1)
      out += wrapped(escaped(r.robot, 40) + ": both times " + significant(r.coupling, 4) +
                         ", the `coupling` of joint '" + escaped(r.joint, 40) + "' to the encoder",
                     width, "  ");
  return out;
}

}  // namespace

std::string to_table(const ThresholdReport& report, const Style& style) {
  std::vector<std::vector<std::string>> cells{{"robot", "counts/rev", "gear", "length", "rate", "resolution",
                                               "threshold", "l/(nG) as printed", "as printed"}};
  for (const ThresholdRow& r : report.rows)
    cells.push_back({escaped(r.robot, 40), significant(r.counts_per_rev, 7), significant(r.gear_ratio, 7),
                     readable(r.length, "m"), readable(r.sample_rate, "Hz"), readable(r.resolution, "m"),
                     readable(r.threshold_velocity(), "m/s"), readable(r.resolution_as_printed, "m"),
                     readable(r.threshold_velocity_as_printed(), "m/s")});
  return painted("Resolution and threshold velocity (Table IV): one count per sample", Paint::bold, style) +
         "\n" + fitted_table(cells, style.width) +
         wrapped(
             "resolution = 2 pi l/(n G); the paper prints l/(n G), which lacks the 2 pi of a revolute joint",
             style.width, "  ") +
         couplings(report, style.width);
}

}  // namespace qerr
