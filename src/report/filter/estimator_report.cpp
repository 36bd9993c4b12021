#include "qerr/report/estimator_report.hpp"

#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "qerr/report/write.hpp"
#include "report/filter/estimator_json.hpp"
#include "report/report_json.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

using Json = nlohmann::ordered_json;

double rate_of(const Spec& spec) {
  const auto derivative = std::find_if(spec.filters.begin(), spec.filters.end(),
                                       [](const NamedFilter& f) { return f.filter.derivative > 0; });
  return (derivative == spec.filters.end() ? spec.filters.front() : *derivative).filter.sample_rate;
}

/// Counts per sample from 0.015, or from below the crossing, to 7.5, or to above it.
std::vector<double> speeds_around(double crossing) {
  std::vector<double> speeds;
  const double first = std::pow(10, std::min(-2.0, std::floor(std::log10(crossing / 2))));
  for (double decade = first; speeds.empty() || speeds.back() < std::max(5.0, 2 * crossing); decade *= 10)
    for (const double digit : {1.5, 3.5, 7.5}) speeds.push_back(digit * decade);
  return speeds;
}

Json to_json(const EstimatorError& e, double speed) {
  Json j;
  for (const auto& [name, error] :
       {std::pair{"printed", e.printed}, {"varying", e.varying}, {"constant", e.constant}})
    j[name] = {{"error", number_or_null(error)}, {"snr_db", number_or_null(worst_case_snr_db(speed, error))}};
  return j;
}

std::string better(const EstimatorRow& row) {
  return row.inverse_time.varying <= row.finite_difference.varying ? "inverse_time" : "finite_difference";
}

std::string decibels(double speed, double error) {
  if (!std::isfinite(error)) return "none";
  return std::to_string(std::lround(worst_case_snr_db(speed, error))) + " dB";
}

bool alike(const EncoderEstimators& a, const EncoderEstimators& b) {
  return a.resolution == b.resolution && a.unit == b.unit;
}

std::string error_text(double error, const std::string& unit) {
  return std::isfinite(error) ? readable(error, unit) : "none";
}

}  // namespace

EstimatorReport estimator_report(const Spec& spec, std::optional<double> clock) {
  EstimatorReport report{rate_of(spec), clock.value_or(rate_of(spec)), {}};
  const auto& joints = spec.model.chain.independent;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const double delta = spec.model.transmission.encoders[i].resolution, one = delta * report.sample_rate;
    EncoderEstimators e{joints[i].name,
                        joints[i].prismatic() ? "m/s" : "rad/s",
                        delta,
                        estimator_crossing(delta, report.sample_rate, report.clock),
                        {}};
    for (const double counts : speeds_around(e.crossing_speed / one))
      e.rows.push_back({counts * one, counts,
                        finite_difference_error(delta, report.sample_rate, counts * one),
                        inverse_time_error(delta, report.clock, counts * one)});
    report.encoders.push_back(std::move(e));
  }
  return report;
}

std::string estimator_table(const EstimatorReport& report) {
  std::string out = "\nVelocity from the counts, worst case: finite differences (FDM) at " +
                    readable(report.sample_rate, "Hz") + ", time between edges (ITM) with a clock of " +
                    readable(report.clock, "Hz") + "\n";
  for (std::size_t i = 0; i < report.encoders.size(); ++i) {
    const EncoderEstimators& e = report.encoders[i];
    std::string names = escaped(e.encoder, 40);
    for (; i + 1 < report.encoders.size() && alike(e, report.encoders[i + 1]); ++i)
      names += ", " + escaped(report.encoders[i + 1].encoder, 40);
    out += "\n" + names + ": ITM is at least as good up to " + readable(e.crossing_speed, e.unit) + "\n";
    std::vector<std::vector<std::string>> rows{
        {"speed", "counts/sample", "FDM error", "SNR", "ITM error", "SNR", "SNR as printed", "better"}};
    for (const EstimatorRow& r : e.rows) {
      const EstimatorError &fdm = r.finite_difference, &itm = r.inverse_time;
      rows.push_back({readable(r.speed, e.unit), significant(r.quanta_per_sample, 3),
                      error_text(fdm.varying, e.unit), decibels(r.speed, fdm.varying),
                      error_text(itm.varying, e.unit), decibels(r.speed, itm.varying),
                      decibels(r.speed, itm.printed), better(r) == "inverse_time" ? "ITM" : "FDM"});
    }
    out += aligned(rows);
  }
  return out +
         "\nITM: for a speed that rises or falls up to the one shown between two edges; none: two edges may "
         "share a\n"
         "tick. The paper's bound (52), as printed, is valid and loose.\n";
}

std::string estimator_csv(const EstimatorReport& report) {
  std::string out = "encoder,speed,unit,quanta_per_sample,estimator,bound,error,snr_db\r\n";
  const auto cell = [](double value) { return std::isfinite(value) ? shortest(value) : std::string(); };
  for (const EncoderEstimators& e : report.encoders)
    for (const EstimatorRow& r : e.rows)
      for (const auto& [estimator, error] :
           {std::pair{"finite_difference", r.finite_difference}, {"inverse_time", r.inverse_time}})
        for (const auto& [bound, value] :
             {std::pair{"printed", error.printed}, {"varying", error.varying}, {"constant", error.constant}})
          out += csv_cell(e.encoder) + ',' + shortest(r.speed) + ',' + e.unit + ',' +
                 shortest(r.quanta_per_sample) + ',' + estimator + ',' + bound + ',' + cell(value) + ',' +
                 cell(worst_case_snr_db(r.speed, value)) + "\r\n";
  return out;
}

Json estimator_json(const EstimatorReport& report) {
  Json list = Json::array();
  for (const EncoderEstimators& e : report.encoders) {
    Json rows = Json::array();
    for (const EstimatorRow& r : e.rows)
      rows.push_back({{"speed", r.speed},
                      {"quanta_per_sample", r.quanta_per_sample},
                      {"finite_difference", to_json(r.finite_difference, r.speed)},
                      {"inverse_time", to_json(r.inverse_time, r.speed)},
                      {"better", better(r)}});
    list.push_back({{"encoder", e.encoder},
                    {"unit", e.unit},
                    {"resolution", e.resolution},
                    {"sample_rate", report.sample_rate},
                    {"clock", report.clock},
                    {"crossing_speed", e.crossing_speed},
                    {"speeds", rows}});
  }
  return list;
}

}  // namespace qerr
