#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "diagnose/record/sanity/sanity_steps.hpp"

/// Faults of the counter behind the encoder: it wraps, or it counts other edges than the spec says.
namespace qerr::sanity {

namespace {

constexpr double least_modulus = 256;
constexpr double slack = 3;  // [counts], of an edge that is not quite where it should be

/// What each row jumps by, beyond what it moves: against the reference, or the steps about it [counts].
Eigen::ArrayXd jumps(const Eigen::ArrayXd& counts, const Eigen::ArrayXd& reference) {
  const Eigen::Index n = counts.size();
  Eigen::ArrayXd out = Eigen::ArrayXd::Zero(n);
  const Eigen::ArrayXd x = reference.size() > 0 ? Eigen::ArrayXd(counts - reference) : counts;
  for (Eigen::Index k = 1; k < n; ++k) {
    out[k] = x[k] - x[k - 1];
    if (reference.size() > 0) continue;
    std::vector<double> about;
    for (Eigen::Index i = std::max<Eigen::Index>(1, k - 2); i <= std::min(n - 1, k + 2); ++i)
      about.push_back(x[i] - x[i - 1]);
    out[k] -= median(std::move(about));
  }
  return out;
}

/// The modulus that all great jumps are one of, a power of two where one is near; 0 when they differ.
double modulus_of(const Eigen::ArrayXd& jump, bool& power) {
  std::vector<double> great;
  for (const double j : jump)
    if (std::abs(j) > 0.75 * least_modulus) great.push_back(std::abs(j));
  if (great.empty()) return 0;
  double modulus = std::round(median(great));
  const double nearest = std::exp2(std::round(std::log2(modulus)));
  power = std::abs(modulus - nearest) <= std::max(4.0, 0.01 * nearest);
  if (power) modulus = nearest;
  if (modulus < least_modulus) return 0;
  const auto other = std::count_if(great.begin(), great.end(), [&](double j) {
    return std::abs(j - modulus) > std::max(2 * slack, 0.05 * modulus);
  });
  return other == 0 ? modulus : 0;
}

/// Where the counter ends, if every jump is at one of its ends: a position modulo the modulus lies between
/// `low` and `high`.
struct Boundary {
  double low = -1e300, high = 1e300;
  int crossings = 0;

  void cross(double before, double after, double modulus) {
    double from = std::min(before, after) - slack, to = std::max(before, after) + slack;
    if (crossings++ > 0) {
      const double turns = std::round((0.5 * (low + high) - 0.5 * (from + to)) / modulus);
      from += turns * modulus;
      to += turns * modulus;
    }
    low = std::max(low, from);
    high = std::min(high, to);
  }

  /// Zero or half the modulus: the ends of a counter without and with a sign.
  bool at_usual_place(double modulus) const { return std::floor(high / (modulus / 2)) * modulus / 2 >= low; }
};

constexpr std::array<double, 8> few_numbers{1, 2, 3, 4, 5, 6, 8, 10};

/// The simple ratio that a slope is, 1 where it is none.
///
/// Those of x1, x2 and x4 may come with a scale error beside them; for others the ratio must be near, as
/// there are many.
double simple_ratio(double slope) {
  const double size = std::abs(slope);
  double best = 1, best_off = 0.03;
  for (const double ratio : {0.125, 0.25, 0.5, 2.0, 4.0, 8.0})
    if (std::abs(size / ratio - 1) < best_off) best = ratio, best_off = std::abs(size / ratio - 1);
  if (best == 1 && (size < 0.7 || size > 1.4)) {
    best_off = 2e-3;
    for (const double a : few_numbers)
      for (const double b : few_numbers)
        if (std::abs(size * b / a - 1) < best_off) best = a / b, best_off = std::abs(size * b / a - 1);
  }
  if (best == 1 && std::abs(size - 1) > 0.1) return 1;
  return slope < 0 ? -best : best;
}

/// Where the interval of true counts that one reading stands for has its middle, less reading/factor
/// [counts]: as the effect has it, reading = floor(factor count + 1/2), counts rounded to nearest or down.
double middle_of_reading(double factor, Rounding rounding) {
  const double every = 1 / std::abs(factor);
  if (every != std::round(every)) return 0;
  const bool even = every == 2 * std::floor(every / 2);
  const double below = std::floor(every / 2) - (factor < 0 && even ? 1 : 0);
  return -below + (rounding == Rounding::nearest ? 0.5 * (every - 1) : 0);
}

/// The greatest number that all differences of whole counts are multiples of.
double common_step(const Eigen::ArrayXd& counts) {
  std::int64_t step = 0;
  for (const double c : counts) step = std::gcd(step, std::llround(c - counts[0]));
  return static_cast<double>(std::max<std::int64_t>(step, 1));
}

/// The counter as it would have gone on, and where it wrapped.
struct Unwrapped {
  Eigen::ArrayXd counts, turns;
  Boundary boundary;

  Unwrapped(const Eigen::ArrayXd& read, const Eigen::ArrayXd& jump, double modulus)
      : counts(read), turns(Eigen::ArrayXd::Zero(read.size())) {
    for (Eigen::Index k = 1; k < counts.size(); ++k) {
      const double more = -std::round(jump[k] / modulus);
      turns[k] = turns[k - 1] + more;
      counts[k] += turns[k] * modulus;
      if (more != 0) boundary.cross(counts[k - 1], counts[k], modulus);
    }
  }
};

/// Brings an unwrapped counter to its reference, as far as whole turns of it go.
void to_reference(Eigen::ArrayXd& counts, const Eigen::ArrayXd& reference, const Encoder& encoder,
                  double modulus) {
  if (reference.size() > 0 && encoder.zero_known)
    counts += modulus * std::round((reference - counts).mean() / modulus);
}

/// A wrap that the spec has is undone without a word, unless the counter wraps at another modulus.
void undo_known_rollover(Sanity& s, std::size_t encoder) {
  const Effect* effect = known(s, encoder, "rollover");
  auto read = readings(s, encoder);
  if (!effect || !read) return;
  const double modulus = effect->number("modulus");
  forget(s, effect);
  const Encoder& model = s.model.transmission.encoders[encoder];
  const Eigen::ArrayXd reference = encoder_reference(s, encoder) / model.resolution;
  const Eigen::ArrayXd jump = jumps(read->counts, reference);
  bool power = false;
  const double shown = modulus_of(jump, power);
  const bool other = shown > 0 && std::abs(shown - modulus) > std::max(2 * slack, 0.05 * modulus);
  if (other || peak_to_peak(read->counts) > modulus + slack) return;
  read->counts = Unwrapped(read->counts, jump, modulus).counts;
  to_reference(read->counts, reference, model, modulus);
  write_back(s, *read, encoder);
}

}  // namespace

double decode(Sanity& s, Readings read, std::size_t encoder, double factor) {
  Encoder& model = s.model.transmission.encoders[encoder];
  const Eigen::ArrayXd reference = encoder_reference(s, encoder);
  const double every = read.whole ? common_step(read.counts) : 1, coarser = every / std::abs(factor);
  Eigen::ArrayXd counts = read.counts / factor;
  if (every == 1) counts += middle_of_reading(factor, model.rounding);
  if (every == 1 && reference.size() > 0 && model.zero_known) {
    const double mean = model.rounding == Rounding::down ? -0.5 * coarser : 0;
    const double edges = std::round((reference / model.resolution - counts).mean() + mean);
    if (std::abs(edges) <= 0.5 * coarser) counts += edges;
  }
  read.counts = counts / coarser;
  model.resolution *= coarser;
  model.counts_per_period = std::max(1.0, model.counts_per_period / coarser);
  write_back(s, read, encoder);
  return reference.size() > 0 ? rms(read.counts * model.resolution - reference) : 0;
}

void check_rollover(Sanity& s, std::size_t encoder) {
  undo_known_rollover(s, encoder);
  auto read = readings(s, encoder);
  if (!read) return;
  const Encoder& model = s.model.transmission.encoders[encoder];
  const double step = model.resolution;
  const Eigen::ArrayXd reference = encoder_reference(s, encoder) / step;
  const Eigen::ArrayXd jump = jumps(read->counts, reference);
  bool power = false;
  double modulus = modulus_of(jump, power);
  // Beyond its own range no counter counts.
  if (modulus == 0 || peak_to_peak(read->counts) > modulus + slack) return;
  Unwrapped whole(read->counts, jump, modulus);
  const Boundary& boundary = whole.boundary;
  if (boundary.crossings == 0 || boundary.low > boundary.high) return;
  // One jump anywhere may be lost counts; not where counters end, nor by 2^15 to the count.
  if (!boundary.at_usual_place(modulus) && boundary.crossings < 5 && !(power && modulus >= 32768)) return;
  double before = 0, after = 0;
  if (reference.size() > 0) {
    if (!power) {  // each jump is a count or so off, their levels are not
      modulus = std::round(-fit_line(whole.turns, read->counts - reference).slope);
      whole = Unwrapped(read->counts, jump, modulus);
    }
    to_reference(whole.counts, reference, model, modulus);
    before = rms(read->counts - reference) * step;
    after = rms(whole.counts - reference) * step;
  }
  const double chance = std::min(1.0, 2 * (boundary.high - boundary.low) / modulus);
  s.causes.push_back(cause(s, encoder, "rollover", {{"modulus", modulus}},
                           std::min(1e-6, std::pow(chance, boundary.crossings)), before, after));
  read->counts = std::move(whole.counts);
  write_back(s, *read, encoder);
}

void check_decoding(Sanity& s, std::size_t encoder) {
  while (const Effect* effect = known(s, encoder, "decoding")) {
    const double factor = effect->number("factor");
    forget(s, effect);
    if (const auto read = readings(s, encoder); read && factor != 0) decode(s, *read, encoder, factor);
  }
  const auto read = readings(s, encoder);
  const double resolution = s.model.transmission.encoders[encoder].resolution;
  const Eigen::ArrayXd reference = encoder_reference(s, encoder) / resolution;
  if (!read || reference.size() == 0 || peak_to_peak(reference) < 64 || peak_to_peak(read->counts) < 8)
    return;
  const Line line = fit_line(reference, read->counts);
  const double factor = simple_ratio(line.slope);
  const double moved = std::abs(line.slope) * standard_deviation(reference);
  if (factor == 1 || line.residual_rms > 0.1 * moved) return;
  const double before = rms(read->counts - reference) * resolution;
  const double after = decode(s, *read, encoder, factor);
  const double tail = moved / std::max(line.residual_rms, 1e-12);
  s.causes.push_back(
      cause(s, encoder, "decoding", {{"factor", factor}}, std::exp(-0.5 * tail * tail), before, after));
}

}  // namespace qerr::sanity
