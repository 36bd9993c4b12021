#include "qerr/report/noise_report.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bound/noise_in_motion.hpp"
#include "core/text.hpp"
#include "filter/norms/transient.hpp"
#include "qerr/bound/quantized_sine.hpp"
#include "qerr/report/write.hpp"
#include "report/filter/noise_json.hpp"
#include "report/report_json.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

using Json = nlohmann::ordered_json;

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
  Dimension unit = joint.prismatic() ? dimension::length : dimension::angle;
  unit.second = -filter.filter.derivative;
  row.unit = unit_name(unit);
  row.motion = m;
  row.counts_per_sample = m.sine ? 2 * std::numbers::pi * counts * m.frequency / rate : counts;
  row.sigma_ipqn = resolution * filter.norms.h2 / std::sqrt(12.0);
  if (!memory && !m.sine) row.sigma = resolution * constant_speed_sigma(filter.filter, counts);
  if (memory)
    row.sigma = resolution * (m.sine ? sine_sigma(*memory, counts, m.frequency / rate)
                                     : constant_speed_sigma(*memory, counts));
  return row;
}

std::string text_of(const MotionQuestion& m) {
  return significant(m.size, 6) + ' ' + m.unit() + (m.sine ? " at " + readable(m.frequency, "Hz") : "");
}

std::string threshold_text(const std::optional<double>& threshold) {
  return threshold ? significant(*threshold, 3) : "not searched";
}

}  // namespace

std::vector<FilterNoise> noise_report(const Spec& spec, const std::vector<MotionQuestion>& motions) {
  std::vector<FilterNoise> report;
  for (const NamedFilter& named : spec.filters) {
    FilterNoise& noise = report.emplace_back();
    noise.filter = named.name;
    const auto memory = followed(named.filter);
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

namespace {

std::string sine_table(const std::vector<SineErrorRow>& rows) {
  if (rows.empty()) return {};
  std::vector<std::vector<std::string>> cells{
      {"encoder", "amplitude", "|mean| up to", "envelope", "mean square / IPQN", "envelope"}};
  for (const SineErrorRow& r : rows)
    cells.push_back(
        {escaped(r.encoder, 40), significant(r.amplitude, 5), significant(r.largest_mean, 3),
         significant(r.mean_envelope, 3),
         significant(12 * r.least_square, 5) + ".." + significant(12 * r.largest_square, 5),
         significant(1 + 12 * r.square_below, 5) + ".." + significant(1 + 12 * r.square_above, 5)});
  return "\nThe quantizer's own error along the sine, in counts, over every position of its zero; the "
         "paper's envelopes "
         "(Appendix B)\n" +
         aligned(cells);
}

}  // namespace

std::string noise_table(const std::vector<FilterNoise>& report, const std::vector<SineErrorRow>& sines) {
  if (report.empty()) return {};
  std::vector<std::vector<std::string>> rows{
      {"filter", "IPQN within 10 % above", "within 1 % above", "noise reaches 99 % after"}};
  for (const FilterNoise& f : report)
    rows.push_back({escaped(f.filter, 40),
                    f.followed ? threshold_text(f.within_10_percent) : "memory too long",
                    f.followed ? threshold_text(f.within_1_percent) : "",
                    f.rise_time ? readable(*f.rise_time, "s") : ""});
  std::string out =
      "\nIPQN: peak speeds of slow sines, in counts per sample, above which it can be believed\n" +
      aligned(rows);
  for (const FilterNoise& f : report) {
    if (f.rows.empty()) continue;
    std::vector<std::vector<std::string>> cells{
        {"encoder", "motion", "counts/sample", "sigma", "IPQN", "ratio"}};
    for (const NoiseRow& row : f.rows)
      cells.push_back({escaped(row.encoder, 40), text_of(row.motion), significant(row.counts_per_sample, 4),
                       row.sigma ? readable(*row.sigma, row.unit) : "not known",
                       readable(row.sigma_ipqn, row.unit),
                       row.sigma && row.sigma_ipqn > 0 ? significant(*row.sigma / row.sigma_ipqn, 4) : ""});
    out += "\n" + escaped(f.filter, 40) + ": sigma of the filtered error of an encoder in motion\n" +
           aligned(cells);
  }
  return out + sine_table(sines);
}

std::string noise_csv(const std::vector<FilterNoise>& report) {
  std::string out =
      "filter,encoder,motion,size,size_unit,frequency [Hz],counts_per_sample,unit,sigma,sigma_ipqn\r\n";
  for (const FilterNoise& f : report)
    for (const NoiseRow& r : f.rows)
      out += csv_cell(f.filter) + ',' + csv_cell(r.encoder) +
             (r.motion.sine ? ",sine," : ",constant_speed,") + shortest(r.motion.size) + ',' +
             r.motion.unit() + ',' + (r.motion.sine ? shortest(r.motion.frequency) : "") + ',' +
             shortest(r.counts_per_sample) + ',' + r.unit + ',' + (r.sigma ? shortest(*r.sigma) : "") + ',' +
             shortest(r.sigma_ipqn) + "\r\n";
  return out;
}

void add_noise(Json& filter, const FilterNoise& f) {
  filter["ipqn_within_10_percent_above"] = number_or_null(f.within_10_percent);
  filter["ipqn_within_1_percent_above"] = number_or_null(f.within_1_percent);
  filter["noise_rise_time_s"] = number_or_null(f.rise_time);
  for (const NoiseRow& r : f.rows) {
    Json row = {{"encoder", r.encoder}, {"motion", r.motion.sine ? "sine" : "constant_speed"}};
    const std::string size = r.motion.sine ? "amplitude" : "speed";
    row[size] = r.motion.size;
    row[size + "_unit"] = r.motion.unit();
    if (r.motion.sine) row["frequency_hz"] = r.motion.frequency;
    row["counts_per_sample"] = r.counts_per_sample;
    row["sigma"] = number_or_null(r.sigma);
    row["sigma_ipqn"] = r.sigma_ipqn;
    row["sigma_unit"] = r.unit;
    filter["in_motion"].push_back(row);
  }
}

Json sine_error_json(const std::vector<SineErrorRow>& rows) {
  Json list = Json::array();
  for (const SineErrorRow& r : rows)
    list.push_back({{"encoder", r.encoder},
                    {"amplitude_counts", r.amplitude},
                    {"largest_mean_counts", r.largest_mean},
                    {"mean_envelope_counts", r.mean_envelope},
                    {"mean_square_counts2", {{"least", r.least_square}, {"largest", r.largest_square}}},
                    {"mean_square_envelope_counts2",
                     {{"least", 1.0 / 12 + r.square_below}, {"largest", 1.0 / 12 + r.square_above}}}});
  return list;
}

}  // namespace qerr
