#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

#include "core/text.hpp"
#include "diagnose/record/sanity/sanity_steps.hpp"
#include "effect/effects/effects.hpp"
#include "simulate/unwrap.hpp"

/// Faults of the counter behind the encoder: it overflows, or it counts other edges than the spec says.
namespace qerr::sanity {

namespace {

/// Modulus from which on the end of a word is told from any other count, that of 8 bits, and the least one of
/// which some overflows at the same count tell.
constexpr double least_word = 256, least_modulus = 32;

/// Counts by which a jump may differ from the modulus: motion and edge errors between two rows (convention).
constexpr double slack = 3;

/// Difference relative to the modulus, for fast motion (convention).
constexpr double relative_slack = 0.05;

/// Modulus of a counter of 15 bits and a sign.
constexpr double signed_word = 32768;

/// Change of the counts at each row, less the motion: that of the reference, or the median change over five
/// rows [counts].
Eigen::ArrayXd jumps_of(const Eigen::ArrayXd& counts, const Eigen::ArrayXd& reference) {
  const Eigen::Index n = counts.size();
  Eigen::ArrayXd out = Eigen::ArrayXd::Zero(n);
  const Eigen::ArrayXd x = reference.size() > 0 ? Eigen::ArrayXd(counts - reference) : counts;
  for (Eigen::Index k = 1; k < n; ++k) {
    out[k] = x[k] - x[k - 1];
    if (reference.size() > 0) continue;
    std::vector<double> changes;
    for (Eigen::Index i = std::max<Eigen::Index>(1, k - 2); i <= std::min(n - 1, k + 2); ++i)
      changes.push_back(x[i] - x[i - 1]);
    out[k] -= median(std::move(changes));
  }
  return out;
}

/// The jumps without those of the reference alone, such as a cell that is far off: at an overflow the counts
/// themselves change by a modulus less the motion, which is shorter than half of it.
Eigen::ArrayXd jumps_of_counter(Eigen::ArrayXd jumps, const Eigen::ArrayXd& counts) {
  for (Eigen::Index k = 1; k < counts.size(); ++k)
    if (2 * std::abs(counts[k] - counts[k - 1]) < std::abs(jumps[k])) jumps[k] = 0;
  return jumps;
}

/// The least jump that is looked for: a small counter that overflows fills its modulus, of which the motion
/// between two rows may take a part. Of larger ones the jumps must be of one size down to those of a byte:
/// between poses the longest ways alone are alike.
double least_jump(const Eigen::ArrayXd& counts) {
  return 0.75 * std::clamp(peak_to_peak(counts) - slack, least_modulus, least_word);
}

/// Whether noise of the reference could reach the size of the smallest jump that is looked for: six standard
/// deviations, by the median absolute deviation (1.48 of it is the standard deviation of a Gaussian).
bool is_hidden_by_noise(const Eigen::ArrayXd& jumps, double least_jump) {
  std::vector<double> sizes(static_cast<std::size_t>(jumps.size()));
  for (std::size_t k = 0; k < sizes.size(); ++k) sizes[k] = std::abs(jumps[static_cast<Eigen::Index>(k)]);
  return 6 * 1.48 * median(std::move(sizes)) > least_jump;
}

/// Whether the counts themselves change anywhere by half of such a jump, without which there is none: what is
/// more of it is motion, by the reference (jumps_of_counter) or by the median of changes that are as small.
bool may_overflow(const Eigen::ArrayXd& counts) {
  const Eigen::Index n = counts.size();
  return ((counts.tail(n - 1) - counts.head(n - 1)).abs() >= 0.5 * least_jump(counts)).any();
}

struct Modulus {
  double counts = 0;  ///< 0: none
  bool power_of_two = false;
};

/// The common size of all large jumps; none if they differ. It is a power of two if one is within 1 %.
Modulus modulus_of(const Eigen::ArrayXd& jumps, double least_jump) {
  std::vector<double> large;
  for (const double j : jumps)
    if (std::abs(j) > least_jump) large.push_back(std::abs(j));
  if (large.empty()) return {};
  double modulus = std::round(median(large));
  const double nearest = std::exp2(std::round(std::log2(modulus)));
  const bool power = std::abs(modulus - nearest) <= std::max(4.0, 0.01 * nearest);
  if (power) modulus = nearest;
  if (modulus < least_modulus) return {};
  const bool same = std::all_of(large.begin(), large.end(), [&](double j) {
    return std::abs(j - modulus) <= std::max(2 * slack, relative_slack * modulus);
  });
  return same ? Modulus{modulus, power} : Modulus{};
}

/// Interval [low, high] that contains the count at which the counter overflows, modulo its modulus, if every
/// jump is an overflow; empty (low > high) if the jumps contradict each other.
struct OverflowPoint {
  double low = -1e300, high = 1e300;
  int overflows = 0;

  /// Intersects the interval with [before, after], the unwrapped counts about one jump.
  void narrow(double before, double after, double modulus) {
    double from = std::min(before, after) - slack, to = std::max(before, after) + slack;
    if (overflows++ > 0) {
      const double turns = std::round((0.5 * (low + high) - 0.5 * (from + to)) / modulus);
      from += turns * modulus;
      to += turns * modulus;
    }
    low = std::max(low, from);
    high = std::min(high, to);
  }

  /// Whether it contains zero or half the modulus: where an unsigned and a signed counter overflow.
  bool at_end_of_word(double modulus) const { return std::floor(high / (modulus / 2)) * modulus / 2 >= low; }
};

/// Numerators and denominators of the ratios that are considered.
constexpr std::array<double, 8> terms_of_ratios{1, 2, 3, 4, 5, 6, 8, 10};

/// The ratio of wrong decoding nearest to a slope, 1 if no ratio is near.
///
/// Ratios of x1, x2 and x4 decoding may be combined with a scale error of up to 3 %. The other ratios lie
/// close to each other, so that the slope must agree within 0.2 % (conventions).
double decoding_ratio(double slope) {
  const double size = std::abs(slope);
  double best = 1, best_off = 0.03;
  for (const double ratio : {0.125, 0.25, 0.5, 2.0, 4.0, 8.0})
    if (std::abs(size / ratio - 1) < best_off) best = ratio, best_off = std::abs(size / ratio - 1);
  if (best == 1 && (size < 0.7 || size > 1.4)) {
    best_off = 2e-3;
    for (const double a : terms_of_ratios)
      for (const double b : terms_of_ratios)
        if (std::abs(size * b / a - 1) < best_off) best = a / b, best_off = std::abs(size * b / a - 1);
  }
  if (best == 1 && std::abs(size - 1) > 0.1) return 1;
  return slope < 0 ? -best : best;
}

/// Centre of the true counts that give one reading, less reading/factor [counts]. The reading is
/// floor(factor count + 1/2), with counts rounded to nearest or down.
double centre_of_reading(double factor, Rounding rounding) {
  const double every = 1 / std::abs(factor);
  if (every != std::round(every)) return 0;
  const bool even = every == 2 * std::floor(every / 2);
  const double below = std::floor(every / 2) - (factor < 0 && even ? 1 : 0);
  return -below + (rounding == Rounding::nearest ? 0.5 * (every - 1) : 0);
}

/// Greatest common divisor of the differences between whole counts.
double common_divisor(const Eigen::ArrayXd& counts) {
  std::int64_t step = 0;
  for (const double c : counts) step = std::gcd(step, std::llround(c - counts[0]));
  return static_cast<double>(std::max<std::int64_t>(step, 1));
}

/// The counts without overflow.
struct Unwrapped {
  Eigen::ArrayXd counts, overflows;  ///< overflows: signed number up to each row
  OverflowPoint overflow_point;

  Unwrapped(const Eigen::ArrayXd& read, const Eigen::ArrayXd& jumps, double modulus)
      : counts(read), overflows(Eigen::ArrayXd::Zero(read.size())) {
    for (Eigen::Index k = 1; k < counts.size(); ++k) {
      const double more = -std::round(jumps[k] / modulus);
      overflows[k] = overflows[k - 1] + more;
      counts[k] += overflows[k] * modulus;
      if (more != 0) overflow_point.narrow(counts[k - 1], counts[k], modulus);
    }
  }
};

/// An overflow of a counter.
struct Overflow {
  double modulus = 0;
  Eigen::ArrayXd counts, overflows;  ///< counts: without it; overflows: signed number up to each row
  double p_value = 1;
};

/// The overflow of a counter between rows that may be more than half of its modulus apart, as poses are:
/// counts - reference has levels, whole moduli apart, and the counts have the range of the modulus, which is
/// shorter than that of the reference.
/// @param order  of the rows: in time, or by position
std::optional<Overflow> overflow_by_levels(const Eigen::ArrayXd& counts, const Eigen::ArrayXd& reference,
                                           const std::vector<Eigen::Index>& order) {
  constexpr double longer = 1.05;  // than the counts go: beyond a scale error
  const double range = peak_to_peak(counts) + 1;
  if (peak_to_peak(reference) < longer * range) return std::nullopt;
  const Eigen::ArrayXd apart = counts - reference;
  // Counts at random fill three quarters of their modulus but for 3 % of all sets of 16 rows.
  std::vector<double> steps;
  const std::vector<Eigen::Index> by_position = ascending_rows(reference);
  for (std::size_t k = 1; k < by_position.size(); ++k) {
    const double step = std::abs(apart[by_position[k]] - apart[by_position[k - 1]]);
    if (step > range - slack && step < range / 0.75) steps.push_back(step);
  }
  if (steps.empty()) return std::nullopt;
  Overflow o;
  o.modulus = std::round(median(std::move(steps)));
  const double nearest = std::exp2(std::round(std::log2(o.modulus)));
  const bool power = nearest >= range && std::abs(o.modulus - nearest) <= std::max(4.0, 0.01 * nearest);
  if (power) o.modulus = nearest;
  if (o.modulus < std::max(least_modulus, range)) return std::nullopt;
  o.overflows = turns_by_difference(apart, order, o.modulus);
  if (!power) o.modulus = std::max(range, std::round(-fit_line(o.overflows, apart).slope));
  o.counts = counts + o.overflows * o.modulus;
  const double interval = peak_to_peak(o.counts - reference);
  // As many rows as a record may have single readings far off are no level.
  const Eigen::Index n = counts.size(), fewest = std::max<Eigen::Index>(3, n / 50);
  const double most = median({o.overflows.begin(), o.overflows.end()});
  if (interval > 0.5 * o.modulus || (o.overflows != most).count() < fewest) return std::nullopt;
  // Probability that n differences at random hold to such an interval, modulo the modulus.
  const auto others = static_cast<double>(n - 1);
  o.p_value = std::exp(std::log(others + 1) + others * std::log(interval / o.modulus));
  return o;
}

/// Adds the multiple of the modulus that brings unwrapped counts nearest to the reference [counts].
void align_with_reference(Eigen::ArrayXd& counts, const Eigen::ArrayXd& reference, const Encoder& encoder,
                          double modulus) {
  if (reference.size() > 0 && encoder.zero_known)
    counts += modulus * std::round((reference - counts).mean() / modulus);
}

/// Whether a counter that overflows where a bit begins reads the same as one whose bit is stuck: both halves
/// of which it is one are all that the motion has.
bool overflows_as(const StuckBit& stuck, const Eigen::ArrayXd& counts) {
  return !stuck.value.value_or(true) && counts.minCoeff() >= 0 &&
         counts.maxCoeff() < std::ldexp(1.0, stuck.bit);
}

/// The rows in time; those of a table, which have no order, by their position.
std::vector<Eigen::Index> rows_in_order(const Sanity& s, const Eigen::ArrayXd& reference) {
  return ascending_rows(s.log.has_time() ? Eigen::ArrayXd::LinSpaced(reference.size(), 0, 1) : reference);
}

/// The whole turns by which the reader has moved a reference were chosen by the readings before they were
/// decoded.
void choose_turns_again(Sanity& s, const Eigen::ArrayXd& measured, std::size_t encoder) {
  const auto column = s.log.find(LogSignal::reference, encoder);
  if (!column || s.model.chain.independent[encoder].prismatic()) return;
  Wraps& wraps = s.log.columns[static_cast<std::size_t>(*column)].wraps;
  if (wraps.start == 0 && wraps.count == 0) return;
  constexpr double turn = 2 * std::numbers::pi;
  const Eigen::ArrayXd apart = measured - s.log.values.col(*column);
  const std::int64_t turns = std::llround(median({apart.begin(), apart.end()}) / turn);
  s.log.values.col(*column) += static_cast<double>(turns) * turn;
  wraps.start += turns;
}

}  // namespace

void judge_in_steps(Sanity& s, RecordedCounts& read, std::size_t encoder, double counts) {
  Encoder& model = s.model.transmission.encoders[encoder];
  read.counts /= counts;
  model.resolution *= counts;
  model.counts_per_period = std::max(1.0, model.counts_per_period / counts);
  for (Effect& e : s.present)
    if (e.type == missed_counts_effect().name && e.joint == s.model.chain.independent[encoder].name)
      e.numbers.at("counts") /= counts;
  write_back(s, read, encoder);
}

double decode(Sanity& s, RecordedCounts read, std::size_t encoder, double factor) {
  Encoder& model = s.model.transmission.encoders[encoder];
  choose_turns_again(s, read.counts / factor * model.resolution, encoder);
  const Eigen::ArrayXd reference = encoder_reference(s, encoder);
  const double divisor = read.direct ? common_divisor(read.counts) : 1;
  const double true_per_reading = divisor / std::abs(factor);
  Eigen::ArrayXd counts = read.counts / factor;
  if (divisor == 1) counts += centre_of_reading(factor, model.rounding);
  if (divisor == 1 && reference.size() > 0 && model.zero_known) {
    const double mean = (below_reading(model) - 0.5) * true_per_reading;
    const double edges = std::round((reference / model.resolution - counts).mean() + mean);
    if (std::abs(edges) <= 0.5 * true_per_reading) counts += edges;
  }
  read.counts = counts;
  judge_in_steps(s, read, encoder, true_per_reading);
  return reference.size() > 0 ? rms(read.counts * model.resolution - reference) : 0;
}

void check_turns(Sanity& s, std::size_t encoder) {
  const auto column = s.log.find(LogSignal::counts, encoder);
  if (!column || !s.log.columns[static_cast<std::size_t>(*column)].wraps.contradicted) return;
  const Encoder& model = s.model.transmission.encoders[encoder];
  const Eigen::ArrayXd reference = reference_in_counts(s, encoder);
  if (reference.size() == 0) return;
  const double turn = std::round(2 * std::numbers::pi / (model.resolution * std::abs(model.shaft_ratio)));
  auto counts = s.log.values.col(*column);
  const Eigen::ArrayXd apart = counts - reference;
  double turns = 0;
  for (Eigen::Index k = 1; k < apart.size(); ++k) {
    turns += std::round((apart[k] - apart[k - 1]) / turn);
    counts[k] -= turns * turn;
  }
}

namespace {

/// The turns of a reference within one turn, or that wraps, were chosen by readings that had overflowed:
/// others are taken if with them the counter has no offset.
void choose_turns_of_overflow(Sanity& s, const Eigen::ArrayXd& counts, std::size_t encoder, double modulus) {
  const auto column = s.log.find(LogSignal::reference, encoder);
  if (!column || s.model.chain.independent[encoder].prismatic()) return;
  constexpr double turn = 2 * std::numbers::pi;
  constexpr int most = 3;  // turns of a joint
  Wraps& wraps = s.log.columns[static_cast<std::size_t>(*column)].wraps;
  auto reference = s.log.values.col(*column);
  if (wraps.start == 0 && wraps.count == 0 && peak_to_peak(reference) > turn) return;
  const double offset = (counts - reference_in_counts(s, encoder)).mean();
  const double turn_in_counts = turn / s.model.transmission.encoders[encoder].resolution;
  const auto offset_with = [&](int turns) {
    return std::abs(std::remainder(offset - turns * turn_in_counts, modulus));
  };
  if (offset_with(0) < slack) return;
  int best = 0;
  for (int turns = -most; turns <= most; ++turns)
    if (offset_with(turns) < std::min(slack, offset_with(best))) best = turns;
  reference += best * turn;
  wraps.start += best;
}

/// The overflow of a counter that moves less than half of its modulus from row to row.
std::optional<Overflow> overflow_by_jumps(const Eigen::ArrayXd& counts, const Eigen::ArrayXd& reference) {
  Eigen::ArrayXd jumps = jumps_of(counts, reference);
  // The counts themselves have no noise of the reference.
  const bool noisy = reference.size() > 0 && is_hidden_by_noise(jumps, least_jump(counts));
  jumps = noisy ? jumps_of(counts, {}) : jumps_of_counter(std::move(jumps), counts);
  auto [modulus, power_of_two] = modulus_of(jumps, least_jump(counts));
  // The range of a counter is its modulus.
  if (modulus == 0 || peak_to_peak(counts) > modulus + slack) return std::nullopt;
  Unwrapped unwrapped(counts, jumps, modulus);
  const OverflowPoint& point = unwrapped.overflow_point;
  if (point.overflows == 0 || point.low > point.high) return std::nullopt;
  // A few jumps at any count may be lost counts, but not at the end of a word or by a power of two >= 2^15.
  const bool of_word = modulus >= least_word && point.at_end_of_word(modulus);
  if (!of_word && point.overflows < 5 && !(power_of_two && modulus >= signed_word)) return std::nullopt;
  // A counter that is right follows even a noisy reference better than one that is unwrapped by mistake.
  if (noisy && standard_deviation(unwrapped.counts - reference) > standard_deviation(counts - reference))
    return std::nullopt;
  if (reference.size() > 0 && !power_of_two && !noisy) {
    // A jump may be off by some counts; the difference between levels is exact.
    modulus = std::round(-fit_line(unwrapped.overflows, counts - reference).slope);
    unwrapped = Unwrapped(counts, jumps, modulus);
  }
  // Probability that a jump at a uniformly random count lies as near to the common overflow point.
  const double probability = std::min(1.0, 2 * (point.high - point.low) / modulus);
  const double p_value = std::pow(probability, point.overflows);
  return Overflow{modulus, std::move(unwrapped.counts), std::move(unwrapped.overflows), p_value};
}

/// Whether counts without overflow differ from the reference by less than a half modulus, but for single
/// readings.
bool is_without_levels(const Overflow& o, const Eigen::ArrayXd& reference) {
  if (reference.size() == 0) return true;
  const Eigen::ArrayXd apart = o.counts - reference;
  const double middle = median({apart.begin(), apart.end()});
  return ((apart - middle).abs() < 0.25 * o.modulus).count() > apart.size() - apart.size() / 50;
}

/// Silently undoes a specified rollover, unless the counter overflows at another modulus.
void undo_specified_rollover(Sanity& s, std::size_t encoder) {
  const Effect* effect = specified_effect(s, encoder, rollover_effect().name);
  if (!effect || !has_counts(s, encoder)) return;
  auto read = recorded_counts(s, encoder);
  const double modulus = effect->number("modulus");
  remove_effect(s, effect);
  const Encoder& model = s.model.transmission.encoders[encoder];
  const Eigen::ArrayXd reference = reference_in_counts(s, encoder);
  const Eigen::ArrayXd jumps = jumps_of_counter(jumps_of(read->counts, reference), read->counts);
  const double observed = modulus_of(jumps, least_jump(read->counts)).counts;
  const bool other =
      observed > 0 && std::abs(observed - modulus) > std::max(2 * slack, relative_slack * modulus);
  if (other || peak_to_peak(read->counts) > modulus + slack) return;
  Unwrapped unwrapped(read->counts, jumps, modulus);
  Overflow specified{modulus, std::move(unwrapped.counts), std::move(unwrapped.overflows)};
  if (!is_without_levels(specified, reference))
    specified.counts = read->counts + modulus * turns_by_difference(read->counts - reference,
                                                                    rows_in_order(s, reference), modulus);
  read->counts = std::move(specified.counts);
  align_with_reference(read->counts, reference, model, modulus);
  write_back(s, *read, encoder);
}

}  // namespace

void check_rollover(Sanity& s, std::size_t encoder) {
  undo_specified_rollover(s, encoder);
  auto read = recorded_counts(s, encoder);
  if (!read) return;
  const Encoder& model = s.model.transmission.encoders[encoder];
  if (!may_overflow(read->counts)) return;
  const Eigen::ArrayXd reference = reference_in_counts(s, encoder);
  std::optional<Overflow> found;
  if (s.log.has_time()) found = overflow_by_jumps(read->counts, reference);
  if (reference.size() > 0 && (!found || !is_without_levels(*found, reference)))
    if (auto levels = overflow_by_levels(read->counts, reference, rows_in_order(s, reference)))
      found = std::move(levels);
  if (!found) return;
  if (const auto stuck = stuck_bit_by_reference(s, encoder)) {
    if (!overflows_as(*stuck, direction(model) * read->counts)) return;
    s.alternatives.push_back({std::string(rollover_effect().name), std::string(stuck_bit_effect().name),
                              s.model.chain.independent[encoder].name,
                              "a motion of more than " + significant(2 * found->modulus, 12) + " counts"});
  }
  double before = 0, after = 0;
  if (reference.size() > 0) {
    choose_turns_of_overflow(s, found->counts, encoder, found->modulus);
    const Eigen::ArrayXd chosen = reference_in_counts(s, encoder);
    align_with_reference(found->counts, chosen, model, found->modulus);
    before = rms(read->counts - reference) * model.resolution;
    after = rms(found->counts - chosen) * model.resolution;
  }
  s.causes.push_back(exact_cause(s, encoder, rollover_effect().name, {{"modulus", found->modulus}},
                                 std::min(1e-6, found->p_value), before, after));
  // The rows of a table have no order: those are told whose count is not that of most.
  const Eigen::ArrayXd& overflows = found->overflows;
  const double most = median({overflows.begin(), overflows.end()});
  Eigen::Index first = -1, number = 0;
  for (Eigen::Index k = 0; k < overflows.size(); ++k) {
    const bool differs = s.log.has_time() ? k > 0 && overflows[k] != overflows[k - 1] : overflows[k] != most;
    if (differs && number++ == 0) first = k;
  }
  const std::string times = number == 1 ? "once" : std::to_string(number) + " times";
  s.data.push_back(
      {"the counter overflows at " + significant(found->modulus, 12) + ' ' +
           (s.log.has_time() ? times
                             : "in " + counted(static_cast<std::uint64_t>(number), "row") + " of the table"),
       s.model.chain.independent[encoder].name, s.log.row_number(first) + 1, time_of(s, first),
       "add the modulus at each overflow where the counts are read, or state the effect in the spec"});
  read->counts = std::move(found->counts);
  write_back(s, *read, encoder);
}

void check_decoding(Sanity& s, std::size_t encoder) {
  while (const Effect* effect = specified_effect(s, encoder, decoding_effect().name)) {  // which is removed
    const double factor = effect->number("factor");
    remove_effect(s, effect);
    if (const auto read = recorded_counts(s, encoder); read && factor != 0) decode(s, *read, encoder, factor);
  }
  if (!has_counts(s, encoder) || !has_reference(s, encoder)) return;
  const auto read = recorded_counts(s, encoder);
  const double resolution = s.model.transmission.encoders[encoder].resolution;
  const Eigen::ArrayXd reference = reference_in_counts(s, encoder);
  // Some rows tell that nothing is to be said.
  if (decoding_ratio(fit_line(some_rows(reference), some_rows(read->counts)).slope) == 1) return;
  if (peak_to_peak(reference) < 64 || peak_to_peak(read->counts) < 8) return;
  const Line line = fit_line(reference, read->counts);
  const double factor = decoding_ratio(line.slope);
  const double explained = std::abs(line.slope) * standard_deviation(reference);
  if (factor == 1 || line.residual_rms > 0.1 * explained) return;
  const double before = rms(read->counts - reference) * resolution;
  const double after = decode(s, *read, encoder, factor);
  if (factor < 0)
    s.data.push_back(
        {"the counts run in the wrong direction: they fall where the reference rises",
         s.model.chain.independent[encoder].name,
         1,
         {},
         "change the sign of gear_ratio in the spec, or exchange the encoder's channels A and B"});
  const double tail = explained / std::max(line.residual_rms, 1e-12);
  s.causes.push_back(exact_cause(s, encoder, decoding_effect().name, {{"factor", factor}},
                                 std::exp(-0.5 * tail * tail), before, after));
}

}  // namespace qerr::sanity
