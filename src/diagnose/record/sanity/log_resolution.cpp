#include <algorithm>
#include <cmath>
#include <numeric>
#include <string_view>
#include <vector>

#include "core/text.hpp"
#include "diagnose/record/sanity/sanity_steps.hpp"
#include "effect/effects/effects.hpp"

/// Positions that are recorded more coarsely than the encoder resolves them.
namespace qerr::sanity {

namespace {

/// rms of the distance from whole counts above which positions are not whole counts: that of a rounding step
/// of 0.04 sqrt(12) = 0.14 counts.
constexpr double off_counts = 0.04;

/// Least range of a column, in steps, for its step to be identified as a rounding (convention).
constexpr double fewest_steps = 32;

/// Share of the residual's standard deviation below which a rounding is not reported: 1 % of its variance.
constexpr double negligible_share = 0.1;

/// Whether the spec has a rounding with this step.
bool is_specified(const Sanity& s, std::size_t joint, double step) {
  const Effect* effect = specified_effect(s, joint, log_rounding_effect().name);
  return effect && std::abs(effect->number("step") - step) < 1e-6 * step;
}

/// Where the counts cannot be restored, the rounding of the file remains in the residual.
/// @param exact  every value is a multiple of the step: it is reported beside errors of any size
void report_rounding(Sanity& s, std::size_t joint, double step, bool exact = false) {
  if (is_specified(s, joint, step)) return;
  const auto column = s.log.find(LogSignal::reference, joint);
  const auto measured = measured_joint(s.log, s.log.values, s.model.transmission, joint);
  double residual_rms = 0;
  if (column && measured) {
    const Eigen::ArrayXd residual = *measured - s.log.values.col(*column);
    if (!exact && step / std::sqrt(12.0) < negligible_share * standard_deviation(residual)) return;
    residual_rms = rms(residual);
  }
  s.causes.push_back(exact_cause(s, joint, log_rounding_effect().name, {{"step", step}}, 1e-300, residual_rms,
                                 residual_rms));
}

/// Whether values that are multiples of a step move by the same number of steps from row to row: then a
/// steady motion makes them multiples, and no rounding. A rounded path keeps its change in nearly all rows
/// only at such a speed, too.
bool is_steady(const Eigen::ArrayXd& values, double step) {
  constexpr double nearly_all = 0.98;
  Eigen::Index moving = 0, same = 0;
  for (Eigen::Index k = 2; k < values.size(); ++k) {
    const double change = std::round((values[k] - values[k - 1]) / step);
    if (change == 0) continue;
    ++moving;
    same += change == std::round((values[k - 1] - values[k - 2]) / step);
  }
  return static_cast<double>(same) > nearly_all * static_cast<double>(moving);
}

/// Ascending, each value once.
Eigen::ArrayXd each_once(Eigen::ArrayXd values) {
  std::ranges::sort(values);
  return values.head(std::unique(values.begin(), values.end()) - values.begin());
}

/// How the cause of counts that are all even, or all odd, is told.
struct EverySecond {
  bool stuck = false;    ///< more likely the last bit than a counter of every second edge
  bool certain = false;  ///< which of both
};

/// A stuck last bit displaces the mean by half a count, up or down by its value. Positions that are rounded
/// to two counts are not displaced; a counter of every second edge is displaced either way, by the edges that
/// it counts; and neither has odd counts, unless its zero does. Any other cause may displace the mean, too.
EverySecond every_second(const Sanity& s, const RecordedCounts& read, std::size_t encoder) {
  const Encoder& model = s.model.transmission.encoders[encoder];
  const bool odd = std::llround(read.counts[0]) % 2 != 0;
  if (!has_reference(s, encoder) || !model.zero_known) return {odd, false};
  const double mean = direction(model) * ((read.counts - reference_in_counts(s, encoder)).mean() -
                                          mean_error(model) / model.resolution);
  const double of_bit = std::abs(mean - (odd ? 0.5 : -0.5)),
               of_counter = std::min(std::abs(mean), std::abs(mean - 0.5));
  const bool stuck = odd || of_bit < of_counter;
  // With a deviation of 0.58 counts the mean of 100 rows is within 0.17 of the true one.
  constexpr double near = 0.2;
  return {stuck, odd ? of_bit < near : !stuck && of_counter < near};
}

/// The other cause of counts that are all even or all odd, where nothing tells them apart.
void hedge_every_second(Sanity& s, std::size_t encoder, bool stuck) {
  const std::string_view bit = stuck_bit_effect().name, counter = log_rounding_effect().name;
  s.alternatives.push_back({std::string(stuck ? bit : counter), std::string(stuck ? counter : bit),
                            s.model.chain.independent[encoder].name,
                            "the encoder's own word beside its counts, or watch the last bit's line"});
}

/// Counts that are all multiples of a number > 1 (beside a constant): a counter with fewer edges than the
/// spec says, whose counts are divided by it.
void check_counts(Sanity& s, RecordedCounts& read, std::size_t encoder) {
  std::int64_t divisor = 0;
  for (Eigen::Index k = 1; k < read.counts.size() && divisor != 1; ++k)
    divisor = std::gcd(divisor, std::llround(read.counts[k] - read.counts[0]));
  const auto every = static_cast<double>(divisor);
  if (divisor < 2 || peak_to_peak(read.counts) < fewest_steps * every ||
      specified_effect(s, encoder, stuck_bit_effect().name))
    return;
  if (are_chosen_in_steps(s, encoder, read.counts, (every * every - 1) / 12)) return;
  // Rows without a time have even steps as soon as they are sorted.
  if (s.log.has_time() ? is_steady(read.counts, every)
                       : !has_reference(s, encoder) && is_steady(each_once(read.counts), every))
    return;
  if (divisor == 2) {
    const EverySecond cause = every_second(s, read, encoder);
    const bool stuck =
        cause.stuck && stuck_bit(direction(s.model.transmission.encoders[encoder]) * read.counts);
    if (!cause.certain) hedge_every_second(s, encoder, stuck);
    if (stuck) return;
  }
  report_rounding(s, encoder, s.model.transmission.encoders[encoder].resolution * every, true);
  read.counts /= every;
  decode(s, read, encoder, 1 / every);
}

/// Positions rounded to `step` counts, step >= 1: the step becomes the resolution of the model.
void coarsen_model(Sanity& s, RecordedCounts& read, std::size_t encoder, double step) {
  Encoder& model = s.model.transmission.encoders[encoder];
  const Eigen::ArrayXd lowest = (read.counts - 0.5 * step).ceil();
  const Eigen::ArrayXd highest = (read.counts + 0.5 * step).floor();
  // Every step holds the same number of counts if that is odd. Else counts on the border between two steps
  // are rounded either way.
  s.rounding_sigma[encoder] = std::abs(std::remainder(step, 2)) < 1e-3
                                  ? sigma(model)
                                  : 0.5 * rms(highest + 1 - lowest - step) * model.resolution;
  if (model.zero_known)
    read.counts = 0.5 * (lowest + highest) + (1 - 2 * below_reading(model)) * (0.5 - 0.5 * step);
  read.counts /= step;
  model.resolution *= step;
  write_back(s, read, encoder);
}

/// Measured positions with too few decimals. Where these still identify the counts, the counts are restored.
void check_measured(Sanity& s, RecordedCounts& read, std::size_t encoder) {
  const double resolution = s.model.transmission.encoders[encoder].resolution;
  const double step = s.log.columns[static_cast<std::size_t>(read.column)].step() / resolution;  // [counts]
  const Eigen::ArrayXd counts = (read.counts + 0.5).floor();
  const Eigen::ArrayXd off = read.counts - counts;
  const bool identifies_counts = off.abs().maxCoeff() <= 0.5 * step + 1e-6;
  if (step >= 1) {
    // A step of about one count may be the encoder's own resolution.
    if (step < 1.01 || peak_to_peak(read.counts) < fewest_steps * step) return;
    report_rounding(s, encoder, step * resolution);
    coarsen_model(s, read, encoder, step);
  } else if (identifies_counts && step < 0.95 && rms(off) > off_counts) {
    if (!is_specified(s, encoder, step * resolution))
      s.causes.push_back(exact_cause(s, encoder, log_rounding_effect().name, {{"step", step * resolution}},
                                     1e-300, rms(off) * resolution, 0));
    read.counts = counts;
    write_back(s, read, encoder);
  } else if (step >= 0.5 && rms(off) > off_counts && peak_to_peak(read.counts) > fewest_steps) {
    report_rounding(s, encoder, step * resolution);
  }
}

/// The smallest change of a reference that often stays constant while the counts change; else 0.
double reference_step(const Eigen::Ref<const Eigen::ArrayXd>& reference, const Eigen::ArrayXd& counts) {
  Eigen::Index constant = 0, changes = 0;
  double smallest = 1e300;
  for (Eigen::Index k = 1; k < counts.size(); ++k) {
    if (counts[k] == counts[k - 1]) continue;
    const double step = std::abs(reference[k] - reference[k - 1]);
    if (step == 0)
      ++constant;
    else
      ++changes, smallest = std::min(smallest, step);
  }
  // A fifth of the counts' changes and more than a few rows, so that coincidentally equal values are ignored.
  return constant > 32 && constant > changes / 4 && changes > 8 ? smallest : 0;
}

void check_reference(Sanity& s, const RecordedCounts& read, std::size_t encoder) {
  const auto column = s.log.find(LogSignal::reference, encoder);
  if (!column || !s.log.has_time()) return;
  LogColumn& reference = s.log.columns[static_cast<std::size_t>(*column)];
  const double resolution = s.model.transmission.encoders[encoder].resolution;
  const double of_file = reference.step();
  const double observed = reference_step(s.log.values.col(*column), read.counts);
  const double step = std::max(observed, of_file);
  if (step < 0.5 * resolution || peak_to_peak(s.log.values.col(*column)) < 8 * of_file) return;
  if (step == of_file && is_steady(s.log.values.col(*column), step)) {
    constexpr int of_double = 15;
    reference.text.most_decimals = of_double;  // the decimals that are written are no rounding
    return;
  }
  const bool too_few_decimals = of_file > 0.5 * observed;
  s.warnings.push_back(reference.header + ": its values are multiples of " + significant(step, 4) + ' ' +
                       reference.unit + ", a count of the encoder is " + significant(resolution, 4) +
                       (too_few_decimals
                            ? ": write more decimals"
                            : ": a reference must be finer than the encoder it is compared with"));
  if (too_few_decimals && of_file > resolution) report_rounding(s, encoder, of_file);
}

}  // namespace

void check_log_resolution(Sanity& s, std::size_t encoder) {
  auto read = recorded_counts(s, encoder);
  if (!read) {  // the position of a joint of several encoders does not determine their counts
    const auto measured = s.log.find(LogSignal::measured, encoder);
    if (!measured) return;
    const double step = s.log.columns[static_cast<std::size_t>(*measured)].step();
    if (step / std::sqrt(12.0) > ideal_sigma(s, encoder) &&
        peak_to_peak(s.log.values.col(*measured)) > fewest_steps * step)
      report_rounding(s, encoder, step);
    return;
  }
  // check_decoding has already converted the readings of a wrongly decoded counter.
  const std::string& joint = s.model.chain.independent[encoder].name;
  const bool decoded = std::any_of(s.causes.begin(), s.causes.end(), [&](const Cause& c) {
    return c.effect.type == decoding_effect().name && c.effect.joint == joint;
  });
  if (!decoded && read->direct) check_counts(s, *read, encoder);
  if (!decoded && !read->direct) check_measured(s, *read, encoder);
  check_reference(s, *recorded_counts(s, encoder), encoder);
}

}  // namespace qerr::sanity
