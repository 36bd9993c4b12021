#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/solve.hpp"
#include "core/text.hpp"
#include "diagnose/record/evidence.hpp"
#include "diagnose/record/sanity/sanity_steps.hpp"
#include "diagnose/record/smooth_path.hpp"
#include "effect/effects/effects.hpp"

/// A bit of the counts that never changes.
namespace qerr::sanity {

std::optional<StuckBit> stuck_bit(const Eigen::ArrayXd& counts) {
  const Eigen::Index n = counts.size();
  const double range = counts.maxCoeff() - counts.minCoeff();
  constexpr int highest = 12;
  std::vector<char> remainders(std::size_t{2} << highest);  // by the largest modulus
  std::size_t missing = remainders.size();
  for (const double count : counts) {
    char& seen = remainders[static_cast<std::size_t>(std::llround(count)) & (remainders.size() - 1)];
    missing -= !std::exchange(seen, 1);
    if (missing == 0) return std::nullopt;
  }
  for (int bit = 0; bit <= highest; ++bit) {
    const Eigen::Index half = Eigen::Index{1} << bit, modulus = 2 * half;
    if (range < 4.0 * static_cast<double>(modulus) || n < 4 * modulus) return std::nullopt;
    std::vector<bool> seen(static_cast<std::size_t>(modulus));
    for (std::size_t r = 0; r < remainders.size(); ++r)
      if (remainders[r]) seen[r % seen.size()] = true;
    const auto present = static_cast<Eigen::Index>(std::count(seen.begin(), seen.end(), true));
    if (2 * present > modulus || 8 * present < 3 * modulus) continue;
    Eigen::Index run = 0, longest = 0;
    for (Eigen::Index k = 0; k < 2 * modulus; ++k) {
      run = seen[static_cast<std::size_t>(k % modulus)] ? 0 : run + 1;
      longest = std::max(longest, run);
    }
    constexpr Eigen::Index fewest_leaps = 10;
    const auto bends = (counts.tail(n - 2) - 2 * counts.segment(1, n - 2) + counts.head(n - 2)).abs();
    if (2 * longest < modulus || (bends >= static_cast<double>(half)).count() < fewest_leaps) continue;
    const auto middle = seen.begin() + half;
    if (std::none_of(middle, seen.end(), [](bool b) { return b; })) return StuckBit{bit, false};
    if (std::none_of(seen.begin(), middle, [](bool b) { return b; })) return StuckBit{bit, true};
    return StuckBit{bit, std::nullopt};
  }
  return std::nullopt;
}

namespace {

/// Errors that readings may have, as they are read or by `other` more: those that together change least from
/// row to row (Viterbi).
Eigen::ArrayXd steadiest(const Eigen::ArrayXd& as_read, double other) {
  const Eigen::Index n = as_read.size();
  std::vector<std::array<bool, 2>> from(static_cast<std::size_t>(n));  // the state of the row before
  std::array<double, 2> cost{};
  for (Eigen::Index k = 1; k < n; ++k) {
    const std::array<double, 2> before = cost;
    for (const bool to : {false, true}) {
      const auto by_way_of = [&](bool state) {
        return before[state] + std::abs(as_read[k] - as_read[k - 1] + other * (to - state));
      };
      const bool best = by_way_of(true) < by_way_of(false);
      from[static_cast<std::size_t>(k)][to] = best;
      cost[to] = by_way_of(best);
    }
  }
  Eigen::ArrayXd errors = as_read;
  bool state = cost[1] < cost[0];
  for (Eigen::Index k = n; k-- > 0; state = from[static_cast<std::size_t>(k)][state])
    if (state) errors[k] += other;
  return errors;
}

Eigen::ArrayXd running_median(const Eigen::ArrayXd& x) {
  constexpr Eigen::Index side = 7;
  Eigen::ArrayXd middle(x.size());
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    const Eigen::Index first = std::max<Eigen::Index>(0, k - side), end = std::min(x.size(), k + side + 1);
    const auto around = x.segment(first, end - first);
    middle[k] = median({around.begin(), around.end()});
  }
  return middle;
}

/// The part of errors that is a constant, a scale and an eccentricity.
/// @param angle  of the encoder's shaft [rad]
Eigen::ArrayXd smooth_part(const Eigen::ArrayXd& errors, const Eigen::ArrayXd& angle) {
  Eigen::MatrixXd columns(errors.size(), 4);
  columns << Eigen::VectorXd::Ones(errors.size()), angle.matrix(), angle.sin().matrix(), angle.cos().matrix();
  return (columns * least_norm_solution(columns, errors.matrix())).array();
}

/// What is to be added to readings, nothing or `other`, so that their errors are those of a constant, a
/// scale, an eccentricity and what changes slowly.
/// @param angle  of the encoder's shaft [rad]
Eigen::ArrayXd restored(const Eigen::ArrayXd& as_read, double other, const Eigen::ArrayXd& angle) {
  constexpr int rounds = 3;
  Eigen::ArrayXd errors = steadiest(as_read, other), added;
  for (int round = 0; round < rounds; ++round) {
    const Eigen::ArrayXd smooth = smooth_part(errors, angle);
    const Eigen::ArrayXd expected = smooth + running_median(errors - smooth);
    added = ((as_read + other - expected).abs() < (as_read - expected).abs())
                .select(Eigen::ArrayXd::Constant(as_read.size(), other), 0.0);
    errors = as_read + added;
  }
  return added;
}

/// The reference [counts], smoothed where there is a motion: near the edges of its halves noise of the
/// reference would take a bit for the other one.
Eigen::ArrayXd path_in_counts(const Sanity& s, std::size_t encoder) {
  const Eigen::ArrayXd reference = reference_in_counts(s, encoder);
  const auto stamps = s.log.find(LogSignal::time);
  if (!stamps || reference.size() == 0 || is_static(reference, 1)) return reference;
  return smooth_path(s.log.values.col(*stamps), reference, 0).position;
}

/// What a stuck bit has taken from each count [counts], by the reference. Errors change slowly with time or,
/// in a table without it, with position.
Eigen::ArrayXd taken_by_bit(const Sanity& s, const RecordedCounts& read, std::size_t encoder, int bit,
                            bool value, const Eigen::ArrayXd& path) {
  const Encoder& model = s.model.transmission.encoders[encoder];
  const double missing = direction(model) * (value ? -1 : 1) * std::ldexp(1.0, bit);
  const auto stamps = s.log.find(LogSignal::time);
  const std::vector<Eigen::Index> rows = ascending_rows(stamps ? s.log.values.col(*stamps).eval() : path);
  Eigen::ArrayXd taken(path.size());
  taken(rows) =
      restored((read.counts - path)(rows), missing, (model.shaft_ratio * model.resolution * path)(rows));
  return taken;
}

/// Takes a bit of counts from the reference. The last one's is not: the noise of readings may be as large.
/// @returns rms of measured - reference before and after [rad or m]
std::pair<double, double> restore_bit(Sanity& s, RecordedCounts& read, std::size_t encoder, int bit,
                                      bool value) {
  const Encoder& model = s.model.transmission.encoders[encoder];
  const Eigen::ArrayXd reference = reference_in_counts(s, encoder);
  if (reference.size() == 0) return {0, 0};
  const Eigen::ArrayXd as_read = read.counts - reference;
  if (bit == 0) {
    read.counts += 0.5 * direction(model) * (value ? -1 : 1);
    judge_in_steps(s, read, encoder, 2);
    return {rms(as_read) * 0.5 * model.resolution, rms(read.counts - 0.5 * reference) * model.resolution};
  }
  read.counts += taken_by_bit(s, read, encoder, bit, value, path_in_counts(s, encoder));
  write_back(s, read, encoder);
  return {rms(as_read) * model.resolution, rms(read.counts - reference) * model.resolution};
}

/// The bits that all counts have, and those that none has.
struct ConstantBits {
  std::int64_t ones = ~std::int64_t{0}, zeros = ~std::int64_t{0};

  explicit ConstantBits(const Eigen::ArrayXd& counts) {
    for (const double count : counts) {
      ones &= std::llround(count);
      zeros &= ~std::llround(count);
    }
  }
};

/// Probability that errors of another cause leap by a bit wherever what it has taken changes.
/// @param apart  rms of the restored errors about a smooth curve [counts]
double chance_of_leaps(const Eigen::ArrayXd& taken, double apart, double bit) {
  const Eigen::Index n = taken.size();
  const auto leaps = static_cast<double>((taken.tail(n - 1) != taken.head(n - 1)).count());
  return std::pow(std::min(1.0, 4 * apart / bit), leaps);  // each within twice the rms, up or down
}

}  // namespace

std::optional<StuckBit> stuck_bit_by_reference(const Sanity& s, std::size_t encoder) {
  // Any errors, brought within half a bit of a curve, are spread evenly: beyond the quantization they have
  // 0.29 of it. Where the bit is wrong in a fiftieth of the readings, the deviation is 0.14 of it; in fewer,
  // a single cell that is far off would do.
  constexpr double of_curve = 0.125, least_part = 0.02, least_deviation = 0.14, by_chance = 1e-4;
  const auto read = recorded_counts(s, encoder);
  if (!read || !read->direct || !has_reference(s, encoder) || read->counts.size() < 32) return std::nullopt;
  const Encoder& model = s.model.transmission.encoders[encoder];
  const Eigen::ArrayXd reference = reference_in_counts(s, encoder);
  const double largest =
      std::min(peak_to_peak(reference), standard_deviation(read->counts - reference) / least_deviation);
  const ConstantBits constant(direction(model) * read->counts);
  Eigen::ArrayXd path;
  for (int bit = 1; std::ldexp(1.0, bit) <= largest; ++bit) {
    const bool value = constant.ones >> bit & 1;
    if (!value && !(constant.zeros >> bit & 1)) continue;
    const double span = std::ldexp(1.0, bit);
    // The other bits go on with the motion: an encoder that rests has no stuck bit.
    if (peak_to_peak(read->counts) < peak_to_peak(reference) - 2 * span) continue;
    if (path.size() == 0) path = path_in_counts(s, encoder);
    const Eigen::ArrayXd taken = taken_by_bit(s, *read, encoder, bit, value, path),
                         errors = read->counts + taken - path;
    const double apart = rms(errors - smooth_part(errors, model.shaft_ratio * model.resolution * path));
    const double part = (taken != 0).cast<double>().mean();
    if (std::min(part, 1 - part) > least_part && apart * apart < 1.0 / 12 + std::pow(of_curve * span, 2) &&
        chance_of_leaps(taken, apart, span) < by_chance)
      return StuckBit{bit, value};
  }
  return std::nullopt;
}

void check_stuck_bit(Sanity& s, std::size_t encoder) {
  if (!s.log.find(LogSignal::counts, encoder)) return;
  auto read = recorded_counts(s, encoder);
  bool is_stated = false;
  while (const Effect* effect = specified_effect(s, encoder, stuck_bit_effect().name)) {  // which is removed
    const auto bit = static_cast<int>(effect->number("bit"));
    const bool value = effect->number("value") != 0;
    remove_effect(s, effect);
    restore_bit(s, *read, encoder, bit, value);
    is_stated = true;
  }
  if (is_stated) return;
  std::optional<StuckBit> stuck = stuck_bit_by_reference(s, encoder);
  if (!stuck && read->counts.size() >= 100) {
    stuck = stuck_bit(direction(s.model.transmission.encoders[encoder]) * read->counts);
    // It makes half of the readings wrong by its count.
    if (stuck && are_chosen_in_steps(s, encoder, read->counts, 0.25 * std::ldexp(1.0, 2 * stuck->bit)))
      return;
  }
  if (!stuck) return;
  s.data.push_back({"bit " + std::to_string(stuck->bit) + " of the counts never changes" +
                        (stuck->value ? *stuck->value ? ", it is 1" : ", it is 0" : "") + ": of every " +
                        significant(std::ldexp(2.0, stuck->bit), 6) + " counts in a row one half is missing",
                    s.model.chain.independent[encoder].name, s.log.row_number(0) + 1, time_of(s, 0),
                    std::string(stuck_bit_effect().remedy.text) +
                        (!stuck->value    ? ""
                         : stuck->bit > 0 ? "; here the bit is taken from the reference"
                                          : "; here readings are judged in steps of two counts"),
                    DataKind::corrupt});
  if (!stuck->value || !has_reference(s, encoder)) return;
  // By chance the counts of all rows lie in one half of the remainders.
  const double by_chance = std::exp2(-static_cast<double>(read->counts.size()));
  const auto [before, after] = restore_bit(s, *read, encoder, stuck->bit, *stuck->value);
  // Four states a line are two bits, of which the readings do not show all.
  if (double& states = s.model.transmission.encoders[encoder].counts_per_period;
      stuck->bit < 2 && states <= 4)
    states = 1;
  s.causes.push_back(exact_cause(s, encoder, stuck_bit_effect().name,
                                 {{"bit", stuck->bit}, {"value", *stuck->value ? 1 : 0}}, by_chance, before,
                                 after));
}

}  // namespace qerr::sanity
