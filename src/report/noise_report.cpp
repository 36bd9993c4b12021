#include "qerr/report/noise_report.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "noise_json.hpp"
#include "qerr/bound/noise_in_motion.hpp"
#include "qerr/filter/transient.hpp"
#include "qerr/report/write.hpp"
#include "text_table.hpp"

namespace qerr {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t most_transient_samples = 100000;

NoiseRow row_of(const NamedFilter& filter, const Autocorrelation& memory, const IndependentJoint& joint,
                double resolution, const MotionQuestion& m) {
  const double rate = filter.filter.sample_rate;
  const double counts = m.in_counts ? m.size : m.size / (m.sine ? resolution : resolution * rate);
  NoiseRow row;
  row.encoder = joint.name;
  Dimension unit = joint.prismatic() ? dimension::length : dimension::angle;
  unit.second = -filter.filter.derivative;
  row.unit = unit_name(unit);
  row.motion = m;
  row.counts_per_sample = m.sine ? 2 * std::numbers::pi * counts * m.frequency / rate : counts;
  row.sigma = resolution * (m.sine ? sine_sigma(memory, counts, m.frequency / rate)
                                   : constant_speed_sigma(memory, counts));
  row.sigma_ipqn = resolution * ipqn_sigma(memory);
  return row;
}

std::string text_of(const MotionQuestion& m, const NoiseRow& row) {
  const std::string speed = shortest_of(row.counts_per_sample, 4) + " counts/sample";
  return m.sine ? "sine, peak " + speed : speed;
}

std::string threshold_text(const std::optional<double>& threshold) {
  return threshold ? shortest_of(*threshold, 3) : "not searched";
}

}  // namespace

std::vector<FilterNoise> noise_report(const Spec& spec, const std::vector<MotionQuestion>& motions) {
  std::vector<FilterNoise> report;
  for (const NamedFilter& named : spec.filters) {
    FilterNoise& noise = report.emplace_back();
    noise.filter = named.name;
    const auto memory = followed(named.filter);
    noise.followed = memory.has_value();
    if (!memory) continue;
    noise.within_10_percent = ipqn_threshold(*memory, 0.1);
    noise.within_1_percent = ipqn_threshold(*memory, 0.01);
    noise.rise_time = noise_rise_time(named.filter, 0.99);
    for (const MotionQuestion& m : motions)
      for (std::size_t i = 0; i < spec.model.transmission.encoders.size(); ++i) {
        const IndependentJoint& joint = spec.model.chain.independent[i];
        if (!m.in_counts && m.length != joint.prismatic()) continue;
        noise.rows.push_back(
            row_of(named, *memory, joint, spec.model.transmission.encoders[i].resolution, m));
      }
  }
  return report;
}

std::string noise_table(const std::vector<FilterNoise>& report) {
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
    std::vector<std::vector<std::string>> cells{{"encoder", "motion", "sigma", "IPQN", "ratio"}};
    for (const NoiseRow& row : f.rows)
      cells.push_back({escaped(row.encoder, 40), text_of(row.motion, row), readable(row.sigma, row.unit),
                       readable(row.sigma_ipqn, row.unit), shortest_of(row.sigma / row.sigma_ipqn, 4)});
    out += "\n" + escaped(f.filter, 40) + ": sigma of the filtered error of an encoder in motion\n" +
           aligned(cells);
  }
  return out;
}

std::string noise_csv(const std::vector<FilterNoise>& report) {
  std::string out = "filter,encoder,motion,size,frequency,counts_per_sample,unit,sigma,sigma_ipqn\r\n";
  for (const FilterNoise& f : report)
    for (const NoiseRow& r : f.rows)
      out += csv_cell(f.filter) + ',' + csv_cell(r.encoder) +
             (r.motion.sine ? ",sine," : ",constant_speed,") + shortest(r.motion.size) + ',' +
             (r.motion.sine ? shortest(r.motion.frequency) : "") + ',' + shortest(r.counts_per_sample) + ',' +
             r.unit + ',' + shortest(r.sigma) + ',' + shortest(r.sigma_ipqn) + "\r\n";
  return out;
}

void add_noise(Json& filter, const FilterNoise& f) {
  const auto or_null = [](const std::optional<double>& value) {
    return value ? Json(*value) : Json(nullptr);
  };
  filter["ipqn_within_10_percent_above"] = or_null(f.within_10_percent);
  filter["ipqn_within_1_percent_above"] = or_null(f.within_1_percent);
  filter["noise_rise_time_s"] = or_null(f.rise_time);
  for (const NoiseRow& r : f.rows) {
    Json row = {{"encoder", r.encoder}, {"motion", r.motion.sine ? "sine" : "constant_speed"}};
    row[r.motion.sine ? "amplitude" : "speed"] = r.motion.size;
    row["in_counts"] = r.motion.in_counts;
    if (r.motion.sine) row["frequency"] = r.motion.frequency;
    row["counts_per_sample"] = r.counts_per_sample;
    row["unit"] = r.unit;
    row["sigma"] = r.sigma;
    row["sigma_ipqn"] = r.sigma_ipqn;
    filter["in_motion"].push_back(row);
  }
}

std::string transient_csv(const Spec& spec) {
  std::string out = "filter,time [s],sigma_over_input\r\n";
  for (const NamedFilter& named : spec.filters) {
    const double rate = named.filter.sample_rate;
    const auto rise = noise_rise_time(named.filter, 0.999);
    const double wanted = rise ? 2 + *rise * rate : static_cast<double>(most_transient_samples);
    const auto count =
        static_cast<std::size_t>(std::min(wanted, static_cast<double>(most_transient_samples)));
    const std::vector<double> sigma = noise_transient(named.filter, count);
    for (std::size_t k = 0; k < sigma.size(); ++k)
      out += csv_cell(named.name) + ',' + shortest(static_cast<double>(k) / rate) + ',' + shortest(sigma[k]) +
             "\r\n";
  }
  return out;
}

}  // namespace qerr
