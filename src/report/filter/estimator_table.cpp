#include <cmath>

#include "report/filter/tables.hpp"
#include "report/fitted_table.hpp"
#include "report/text_table.hpp"
#include "report/wrapped_text.hpp"

namespace qerr {

namespace {

std::string decibels(double speed, double error) {
  if (!std::isfinite(error)) return "-";
  return std::to_string(std::lround(worst_case_snr_db(speed, error))) + " dB";
}

bool same_encoder(const EncoderEstimators& a, const EncoderEstimators& b) {
  return a.resolution == b.resolution && a.unit == b.unit && a.edges == b.edges;
}

std::string error_text(double error, const std::string& unit) { return readable(error, unit); }

}  // namespace

std::string estimator_table(const EstimatorReport& report, std::size_t width) {
  std::string out = "\nVelocity from counts, worst case: finite differences (FDM) at " +
                    readable(report.sample_rate, "Hz") + ",\ntime between edges (ITM) with a clock of " +
                    readable(report.clock, "Hz") + "\n";
  for (std::size_t i = 0; i < report.encoders.size(); ++i) {
    const EncoderEstimators& e = report.encoders[i];
    std::string names = escaped(e.encoder, 40);
    for (; i + 1 < report.encoders.size() && same_encoder(e, report.encoders[i + 1]); ++i)
      names += ", " + escaped(report.encoders[i + 1].encoder, 40);
    out += "\n" + wrapped(names + ": ITM is at least as good up to " + readable(e.crossing_speed, e.unit) +
                              (e.edges.ideal() ? ""
                                               : "; with the effects of the disc, whose edges are " +
                                                     significant(e.edges.shortest, 3) + " to " +
                                                     significant(e.edges.longest, 3) + " counts apart"),
                          width);
    std::vector<std::vector<std::string>> rows{
        {"speed", "counts per sample", "FDM error", "SNR", "ITM error", "SNR", "SNR as printed", "better"}};
    for (const EstimatorRow& r : e.rows) {
      const EstimatorError &fdm = r.finite_difference, &itm = r.inverse_time;
      rows.push_back({readable(r.speed, e.unit), significant(r.quanta_per_sample, 3),
                      error_text(fdm.varying, e.unit), decibels(r.speed, fdm.varying),
                      error_text(itm.varying, e.unit), decibels(r.speed, itm.varying),
                      decibels(r.speed, itm.printed), r.inverse_time_is_better() ? "ITM" : "FDM"});
    }
    out += fitted_table(rows, width);
  }
  return out + "\n" +
         wrapped(
             "ITM: for a speed that rises or falls up to the one shown between two edges; unbounded: two "
             "edges may "
             "fall into one tick. The paper's bound (52), as printed, is valid and loose.",
             width);
}

}  // namespace qerr
