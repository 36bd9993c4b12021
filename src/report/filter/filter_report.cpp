#include "qerr/report/filter_report.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "bound/noise_in_motion.hpp"
#include "core/text.hpp"
#include "filter/norms/autocorrelation.hpp"
#include "qerr/core/error.hpp"
#include "qerr/core/quantity.hpp"
#include "report/rows.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

double counts_of(const MotionQuestion& m, double resolution, double rate) {
  return m.in_counts ? m.size : m.size / (m.sine ? resolution : resolution * rate);
}

bool concerns(const MotionQuestion& m, const IndependentJoint& joint) {
  return m.in_counts || m.length == joint.prismatic();
}

NoiseRow row_of(const NamedFilter& filter, const std::optional<Autocorrelation>& memory,
                const IndependentJoint& joint, double resolution, const MotionQuestion& m) {
  const double rate = filter.filter.sample_rate, counts = counts_of(m, resolution, rate);
  NoiseRow row;
  row.encoder = joint.name;
  row.unit =
      unit_name(output_dimension(joint.prismatic() ? dimension::length : dimension::angle, filter.filter));
  row.motion = m;
  row.counts_per_sample = m.sine ? 2 * std::numbers::pi * counts * m.frequency / rate : counts;
  row.sigma_ipqn = resolution * filter.norms.h2 / std::sqrt(12.0);
  if (!memory && !m.sine) row.sigma = resolution * constant_speed_sigma(filter.filter, counts);
  if (memory)
    row.sigma = resolution * (m.sine ? sine_sigma(*memory, counts, m.frequency / rate)
                                     : constant_speed_sigma(*memory, counts));
  return row;
}

/// For every filter the noise of every encoder in every motion; an encoder is skipped if the motion's unit is
/// not that of its joint.
std::vector<FilterNoise> noise_report(const Spec& spec, const std::vector<MotionQuestion>& motions) {
  std::vector<FilterNoise> report;
  for (const NamedFilter& named : spec.filters) {
    FilterNoise& noise = report.emplace_back();
    noise.filter = named.name;
    const auto memory = autocorrelation_within(named.filter);
    noise.followed = memory.has_value();
    if (memory) {
      noise.within_10_percent = ipqn_threshold(*memory, 0.1);
      noise.within_1_percent = ipqn_threshold(*memory, 0.01);
    }
    noise.rise_time = noise_rise_time(named.filter, 0.99);
    for (const MotionQuestion& m : motions)
      for (std::size_t i = 0; i < spec.model.transmission.encoders.size(); ++i) {
        const IndependentJoint& joint = spec.model.chain.independent[i];
        if (!concerns(m, joint)) continue;
        noise.rows.push_back(row_of(named, memory, joint, spec.model.transmission.encoders[i].resolution, m));
      }
  }
  return report;
}

/// For every encoder and every sine among the motions.
std::vector<SineErrorRow> sine_errors(const Spec& spec, const std::vector<MotionQuestion>& motions) {
  constexpr int zeros = 2000;  // positions of the quantizer's zero that are tried
  std::vector<SineErrorRow> rows;
  for (const MotionQuestion& m : motions)
    for (std::size_t i = 0; i < spec.model.transmission.encoders.size(); ++i) {
      const IndependentJoint& joint = spec.model.chain.independent[i];
      if (!m.sine || !concerns(m, joint)) continue;
      SineErrorRow row;
      row.encoder = joint.name;
      row.amplitude = std::abs(counts_of(m, spec.model.transmission.encoders[i].resolution, 1));
      row.least_square = 1;
      for (int z = 0; z < zeros; ++z) {
        const double zero = static_cast<double>(z) / zeros;
        const double square = quantized_sine_mean_square(zero, row.amplitude);
        row.largest_mean = std::max(row.largest_mean, std::abs(quantized_sine_mean(zero, row.amplitude)));
        row.least_square = std::min(row.least_square, square);
        row.largest_square = std::max(row.largest_square, square);
      }
      const SineEnvelope envelope = quantized_sine_envelope(row.amplitude);
      row.mean_envelope = envelope.mean;
      row.square_below = envelope.mean_square_below;
      row.square_above = envelope.mean_square_above;
      rows.push_back(row);
    }
  return rows;
}

FilterFigures figures_of(const NamedFilter& named, const FilterQuestions& q) {
  const Filter& filter = named.filter;
  FilterFigures f{named.name,
                  filter,
                  named.norms,
                  group_delay(filter),
                  poles_max_modulus(filter),
                  bandwidth(filter),
                  estimates_its_derivative(filter) ? std::optional(noise_bandwidth(filter, named.norms.h2))
                                                   : std::nullopt,
                  settling_time(filter),
                  {},
                  {},
                  named.designed};
  for (const double frequency : q.frequencies) f.fidelity.push_back(fidelity(filter, frequency));
  if (q.motion_band) f.tracking = band_tracking(filter, q.motion_band->first, q.motion_band->second);
  return f;
}

/// What a filter that does not estimate its derivative does. @param gain  at low frequencies, not 1
std::string instead(double gain) {
  if (std::isinf(gain)) return " and estimates a lower one: its gain grows without bound at low frequencies";
  const std::string yields = ", and at low frequencies yields " + significant(gain, 4) + " of it: ";
  return yields + (gain < -0.5 && gain > -2 ? "is the sign of its numerator right?"
                                            : "are its coefficients scaled by 1/T?");
}

double rate_of(const Spec& spec) {
  const auto derivative =
      std::ranges::find_if(spec.filters, [](const NamedFilter& f) { return f.filter.derivative > 0; });
  return (derivative == spec.filters.end() ? spec.filters.front() : *derivative).filter.sample_rate;
}

/// The timer's frequency: of the question, else of the spec's first estimator that has one, else the rate.
double clock_of(const Spec& spec, std::optional<double> asked) {
  if (asked) return *asked;
  for (const EstimatorDesign& d : spec.estimators)
    if (const auto clock = d.numbers.find("clock"); clock != d.numbers.end()) return clock->second;
  return rate_of(spec);
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

/// Every n-th sample of a filter's memory.
struct Thinning {
  std::size_t count, every;
};

/// Until the slowest pole has decayed to exp(-30); at most 1e5 samples of the first 2e7.
Thinning thinning(const Filter& filter) {
  constexpr double most_written = 1e5, most_computed = 2e7;
  const double modulus = poles_max_modulus(filter);
  const double decay = modulus < 1 ? -30 / std::log(std::max(modulus, 1e-3)) : INFINITY;
  const double wanted = std::min(16 + static_cast<double>(filter.taps.size()) + decay, most_computed);
  const double every = std::ceil(wanted / most_written);
  return {static_cast<std::size_t>(wanted / every), static_cast<std::size_t>(every)};
}

}  // namespace

std::string MotionQuestion::unit() const {
  if (in_counts) return sine ? "counts" : "counts/sample";
  return std::string(length ? "m" : "rad") + (sine ? "" : "/s");
}

std::vector<std::string> filter_warnings(const Spec& spec) {
  std::vector<std::string> warnings;
  for (const NamedFilter& f : spec.filters) {
    const int d = f.filter.derivative;
    if (f.filter.unit && *f.filter.unit != Dimension{.second = -d}) continue;  // a control law
    if (has_unknown_unit(f.filter))
      warnings.push_back(
          "filter '" + f.name +
          "' states no derivative, and passes constants scaled by H(1) = " + significant(f.norms.dc_gain, 4) +
          ": its output has no unit here; write unit: N m/rad (or another one) for a control law, "
          "derivative: 0 for an estimate of the position, or is its numerator right?");
    else if (d == 0 && std::abs(f.norms.dc_gain - 1) > 0.01)
      warnings.push_back("filter '" + f.name +
                         "' estimates a position, and passes constants scaled by H(1) = " +
                         significant(f.norms.dc_gain, 4) + ": is its numerator right?");
    if (d == 0) continue;
    const std::string stated =
        "filter '" + f.name + "' is specified to estimate derivative " + std::to_string(d);
    if (std::abs(f.norms.dc_gain) > 1e-9 * f.norms.h2)
      warnings.push_back(stated + " and passes constants: H(1) = " + significant(f.norms.dc_gain, 4));
    else if (!estimates_its_derivative(f.filter))
      warnings.push_back(stated + instead(low_frequency_gain(f.filter)));
    else if (!passes_slow_motion(f.filter))
      warnings.push_back("filter '" + f.name + "' passes slow motion with a gain of " +
                         significant(low_frequency_gain(f.filter), 4) +
                         ", and its noise with it: divide both by the gain before you compare filters");
  }
  return warnings;
}

FilterReport filter_report(const Spec& spec, const FilterQuestions& q) {
  FilterReport report{spec, q, {}, {}};
  if (q.noise || !q.motions.empty()) report.noise = noise_report(spec, q.motions);
  report.sine_errors = sine_errors(spec, q.motions);
  for (const NamedFilter& named : spec.filters) {
    double highest = q.motion_band ? q.motion_band->second : 0;
    for (const double f : q.frequencies) highest = std::max(highest, f);
    for (const MotionQuestion& m : q.motions) highest = std::max(highest, m.frequency);
    if (highest > 0.5 * named.filter.sample_rate)
      throw Error({spec.file, 0, 0}, "filters." + named.name + ".sample_rate",
                  "a frequency that the command line asks for lies above half of the sample rate",
                  shortest(highest) + " Hz at " + shortest(named.filter.sample_rate) + " Hz",
                  "ask for frequencies up to " + shortest(0.5 * named.filter.sample_rate) + " Hz",
                  Trouble::usage);
    report.filters.push_back(figures_of(named, q));
  }
  if (q.estimators) report.estimators = estimator_report(spec, q.clock);
  report.warnings = spec.warnings;
  append(report.warnings, filter_warnings(spec));
  return report;
}

EstimatorReport estimator_report(const Spec& spec, std::optional<double> clock) {
  EstimatorReport report{rate_of(spec), clock_of(spec, clock), {}};
  const auto& joints = spec.model.chain.independent;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const Encoder& encoder = spec.model.transmission.encoders[i];
    const double delta = encoder.resolution, one = delta * report.sample_rate;
    const EdgeErrors edges = edge_errors(encoder, spec.effects, joints[i].name);
    EncoderEstimators e{joints[i].name, joints[i].prismatic() ? "m/s" : "rad/s",
                        delta,          estimator_crossing(delta, report.sample_rate, report.clock, edges),
                        edges,          {}};
    for (const double counts : speeds_around(e.crossing_speed / one)) {
      e.rows.push_back({counts * one, counts,
                        finite_difference_error(delta, report.sample_rate, counts * one, edges),
                        inverse_time_error(delta, report.clock, counts * one, edges)});
      if (edges.ideal() && edges.slope == 0) continue;
      // The paper's bounds are those of ideal edges: this disc exceeds them.
      e.rows.back().finite_difference.printed = e.rows.back().inverse_time.printed =
          std::numeric_limits<double>::infinity();
    }
    report.encoders.push_back(std::move(e));
  }
  return report;
}

std::string response_csv(const FilterReport& report) {
  constexpr int points = 500;
  std::string out = "filter,frequency [Hz],magnitude,phase [rad]\r\n";
  for (const FilterFigures& f : report.filters) {
    const double last = 0.5 * f.filter.sample_rate;
    const double first = std::min(1e-5 * f.filter.sample_rate, 1e-3 * f.bandwidth.value_or(last));
    for (int i = 0; i <= points; ++i) {
      const double frequency =
          i == points ? last : first * std::pow(last / first, static_cast<double>(i) / points);
      const std::complex<double> h = response(f.filter, frequency);
      out += csv_cell(f.name) + ',' + shortest(frequency) + ',' + shortest(std::abs(h)) + ',' +
             shortest(std::arg(h)) + "\r\n";
    }
  }
  return out;
}

std::string impulse_csv(const FilterReport& report) {
  std::string out = "filter,time [s],value\r\n";
  for (const FilterFigures& f : report.filters) {
    const Thinning t = thinning(f.filter);
    const std::vector<double> h = impulse_response(f.filter, t.count, t.every);
    for (std::size_t k = 0; k < h.size(); ++k)
      out += csv_cell(f.name) + ',' + shortest(static_cast<double>(k * t.every) / f.filter.sample_rate) +
             ',' + shortest(h[k]) + "\r\n";
  }
  return out;
}

std::string transient_csv(const Spec& spec) {
  std::string out = "filter,time [s],sigma_over_input,steady_state\r\n";
  for (const NamedFilter& named : spec.filters) {
    const Thinning t = thinning(named.filter);
    const std::vector<double> sigma = noise_transient(named.filter, t.count, t.every);
    for (std::size_t k = 0; k < sigma.size(); ++k) {
      out += csv_cell(named.name) + ',' +
             shortest(static_cast<double>(k * t.every) / named.filter.sample_rate) + ',' +
             shortest(sigma[k]) + ',' + shortest(named.norms.h2) + "\r\n";
      if (sigma[k] >= 0.9999 * named.norms.h2) break;
    }
  }
  return out;
}

}  // namespace qerr
