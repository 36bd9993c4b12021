#include <algorithm>
#include <cmath>

#include "qerr/report/filter_report.hpp"

namespace qerr {

namespace {

double rate_of(const Spec& spec) {
  const auto derivative = std::find_if(spec.filters.begin(), spec.filters.end(),
                                       [](const NamedFilter& f) { return f.filter.derivative > 0; });
  return (derivative == spec.filters.end() ? spec.filters.front() : *derivative).filter.sample_rate;
}

/// Counts per sample from 0.015, or from below the crossing, to 7.5, or to above it.
std::vector<double> speeds_around(double crossing) {
  std::vector<double> speeds;
  const double first =
      crossing > 0 ? std::pow(10, std::min(-2.0, std::floor(std::log10(crossing / 2)))) : 0.01;
  for (double decade = first; speeds.empty() || speeds.back() < std::max(5.0, 2 * crossing); decade *= 10)
    for (const double digit : {1.5, 3.5, 7.5}) speeds.push_back(digit * decade);
  return speeds;
}

}  // namespace

EstimatorReport estimator_report(const Spec& spec, std::optional<double> clock) {
  EstimatorReport report{rate_of(spec), clock.value_or(rate_of(spec)), {}};
  const auto& joints = spec.model.chain.independent;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const Encoder& encoder = spec.model.transmission.encoders[i];
    const double delta = encoder.resolution, one = delta * report.sample_rate;
    const EdgeErrors edges = edge_errors(encoder, spec.effects, joints[i].name);
    EncoderEstimators e{joints[i].name, joints[i].prismatic() ? "m/s" : "rad/s",
                        delta,          estimator_crossing(delta, report.sample_rate, report.clock, edges),
                        edges,          {}};
    for (const double counts : speeds_around(e.crossing_speed / one))
      e.rows.push_back({counts * one, counts,
                        finite_difference_error(delta, report.sample_rate, counts * one, edges),
                        inverse_time_error(delta, report.clock, counts * one, edges)});
    report.encoders.push_back(std::move(e));
  }
  return report;
}

}  // namespace qerr
