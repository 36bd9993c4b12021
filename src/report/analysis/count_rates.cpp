#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/text.hpp"
#include "report/analysis/effects.hpp"
#include "report/analysis/figures.hpp"
#include "report/analysis/tables.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

const char* const speed_remedy =
    "add `motion:`, or velocity to the <limit> of the joints in the URDF (or to robot.joint)";

std::string per_second(double rate) { return significant(rate, 4) + " counts/s"; }

const std::string& joint_name(const Spec& spec, std::size_t encoder) {
  return spec.model.chain.independent[encoder].name;
}

}  // namespace

EncoderSpeeds encoder_speeds(const Spec& spec) {
  EncoderSpeeds speeds;
  for (const Usage& u : usage_of(spec).encoders)
    speeds.push_back(u.velocity ? std::optional(u.velocity->largest()) : std::nullopt);
  return speeds;
}

std::optional<CountLimit> count_limit(const Spec& spec, std::size_t encoder) {
  const EncoderFigures& figures = spec.encoder_figures[encoder];
  std::optional<CountLimit> limit;
  if (figures.max_count_rate) limit = {*figures.max_count_rate, "the fastest that it can count"};
  if (!figures.counter_bits || spec.filters.empty()) return limit;
  double slowest = spec.filters.front().filter.sample_rate;
  for (const NamedFilter& f : spec.filters) slowest = std::min(slowest, f.filter.sample_rate);
  const double of_counter = std::ldexp(slowest, *figures.counter_bits - 1);
  if (!limit || of_counter < limit->rate)
    limit = {of_counter, "half a turn of its " + std::to_string(*figures.counter_bits) +
                             "-bit counter in a sample at " + readable(slowest, "Hz")};
  return limit;
}

double count_rate(const Spec& spec, std::size_t encoder, double speed) {
  const double shaft = std::abs(spec.model.transmission.encoders[encoder].shaft_ratio) * speed;
  return shaft / (2 * std::numbers::pi) * spec.encoder_figures[encoder].counts_per_rev;
}

std::optional<double> largest_speed(const Spec& spec, std::size_t encoder) {
  const std::optional<CountLimit> limit = count_limit(spec, encoder);
  return limit ? std::optional(limit->rate / count_rate(spec, encoder, 1)) : std::nullopt;
}

std::string count_rate_table(const Spec& spec, const Style& style) {
  TableRows rows{{"encoder", "largest speed", "count rate", "highest count rate", "followed up to", "limit"}};
  const EncoderSpeeds speeds = encoder_speeds(spec);
  for (std::size_t i = 0; i < speeds.size(); ++i) {
    const std::optional<CountLimit> limit = count_limit(spec, i);
    if (!limit) continue;
    const std::string unit = spec.model.chain.independent[i].prismatic() ? "m/s" : "rad/s";
    rows.push_back({shortened(joint_name(spec, i), 22), speeds[i] ? readable(*speeds[i], unit) : "not known",
                    speeds[i] ? per_second(count_rate(spec, i, *speeds[i])) : "not known",
                    per_second(limit->rate), readable(*largest_speed(spec, i), unit), limit->what});
  }
  return table_section("Counters: can they follow the joints?", rows, style);
}

std::string count_rate_text(const Spec& spec, std::size_t encoder, double speed) {
  const bool prismatic = spec.model.chain.independent[encoder].prismatic();
  const CountLimit limit = *count_limit(spec, encoder);
  return per_second(count_rate(spec, encoder, speed)) + " at " +
         readable(speed, prismatic ? "m/s" : "rad/s") +
         (spec.motion ? " (the largest speed along `motion:`), at most "
                      : " (the URDF's velocity limit), at most ") +
         per_second(limit.rate) + ", " + limit.what;
}

std::vector<std::string> count_rate_warnings(const Spec& spec) {
  std::vector<std::string> warnings;
  std::optional<EncoderSpeeds> speeds;
  for (std::size_t i = 0; i < spec.encoder_figures.size(); ++i) {
    const std::optional<CountLimit> limit = count_limit(spec, i);
    if (!limit) continue;
    if (!speeds) speeds = encoder_speeds(spec);
    const std::string joint = "the encoder of joint " + quoted(joint_name(spec, i));
    if (!(*speeds)[i])
      warnings.push_back("whether " + joint + " can count fast enough is not known: its speed is not; " +
                         speed_remedy);
    else if (count_rate(spec, i, *(*speeds)[i]) > limit->rate)
      warnings.push_back(joint + " cannot count fast enough: " + count_rate_text(spec, i, *(*speeds)[i]));
  }
  return warnings;
}

double required_count_rate(const Requirement& r, const Spec& spec, const EncoderSpeeds& speeds) {
  const auto i = static_cast<std::size_t>(r.counter);
  if (speeds[i]) return count_rate(spec, i, *speeds[i]);
  throw requirement_error(
      r, "the rate of counts is not known, as the speed of joint " + quoted(joint_name(spec, i)) + " is not",
      speed_remedy);
}

}  // namespace qerr
