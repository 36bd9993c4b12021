#include "report/filter/noise.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bound/noise_in_motion.hpp"
#include "filter/norms/transient.hpp"
#include "qerr/bound/velocity_estimators.hpp"

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

}  // namespace

std::string MotionQuestion::unit() const {
  if (in_counts) return sine ? "counts" : "counts/sample";
  return std::string(length ? "m" : "rad") + (sine ? "" : "/s");
}

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

}  // namespace qerr
