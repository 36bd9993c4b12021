#include <algorithm>
#include <bitset>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/random.hpp"
#include "filter/run/cascade.hpp"
#include "simulate/along_motion.hpp"
#include "simulate/count_errors.hpp"
#include "simulate/motion_path.hpp"
#include "simulate/unrounded_record.hpp"

namespace qerr {

namespace {

/// Edges that all zeros together are to cross: then the mean over the zeros is within 0.2 % of its limit.
constexpr double enough_crossings = 131072;
constexpr double fewest_zeros = 64, most_zeros = 4096;

/// Zeros that D different positions within a count need. One zero in each of K equal parts of a count
/// misplaces each of the M edges in the filter's memory by up to a part, which changes the square of the
/// output by 2 sqrt(12/M) of its mean: a relative standard deviation of 1.7/(K sqrt(max(D/M, 1))) in sigma,
/// 0.17 %.
double enough_zeros(const Filter& filter, double distinct) {
  // Most of the response of a pole p is within 5/(1 - |p|) samples.
  const auto finite = static_cast<double>(filter.taps.size() + 2 * filter.sections.size());
  const double memory = 1 + finite + 5 / std::max(1 - poles_max_modulus(filter), 1e-6);
  return 1000 * std::sqrt(std::min(1.0, memory / distinct));
}

/// Zeros that a record of so many samples affords in a simulation: at a whole number of counts per sample, or
/// simple fractions, a record of any length shows few positions within a count.
double affordable_zeros(double samples) { return std::min(0x1p21 / samples, 256.0); }

/// Positions of the zero, with their weights in the mean.
struct Zeros {
  std::vector<double> positions, weights;

  /// Over a count. At the zeros where the record crosses no edge the error is a constant less the motion, and
  /// its filtered square quadratic in the constant: two Gauss points are exact.
  Zeros(const Filter& filter, const Travel& t, double samples) {
    constexpr double most_evaluated = 0x1p27;
    const double crossed = std::min(t.range(), 1.0), from = 0.5 - t.upper;
    const double wanted = std::max(enough_crossings * crossed / t.length, enough_zeros(filter, t.distinct));
    const std::size_t count = number(wanted, samples, most_evaluated, most_zeros);
    add_parts(from, crossed, crossed < 1 ? count - 2 : count);
    for (double& position : positions) position = std::remainder(position, 1.0);
    if (crossed == 1) return;
    const double half = 0.5 * (1 - crossed), middle = from + crossed + half;
    for (const double side : {-1, 1})
      add(std::remainder(middle + side * half / std::numbers::sqrt3, 1.0), half);
  }

  /// Over a line of `span` counts: the edges in the memory are `span` times as many, so that sqrt(span) times
  /// as many zeros are wanted. Noise of s counts leaves harmonics of a count below 8/s (its factor of the
  /// next is exp(-128 pi^2)), which 16/s equally spaced zeros integrate exactly.
  /// @param noise  [counts]
  /// @param most   of all samples that are evaluated
  Zeros(const Filter& filter, double span, const Travel& t, double samples, double noise, double most) {
    double wanted = std::sqrt(span) *
                    std::max(enough_crossings / std::max(t.length, 1.0), enough_zeros(filter, t.distinct));
    const bool smooth = wanted * noise > 16 * span;
    if (smooth) wanted = 16 * span / noise;
    add_parts(-0.5 * span, span, number(wanted, samples, most, most_zeros * std::min(std::sqrt(span), 2.0)),
              !smooth);
    for (double& weight : weights) weight /= span;
  }

 private:
  static std::size_t number(double wanted, double samples, double most_evaluated, double most) {
    most = std::clamp(most_evaluated / samples, fewest_zeros, most);
    return static_cast<std::size_t>(std::clamp(wanted, fewest_zeros, most) / 8) * 8;  // whole vectors
  }

  /// A random position in each of equal parts, where equally spaced ones would share every misplacement of an
  /// edge at simple fractions of a count per sample; or the middle of each.
  void add_parts(double from, double length, std::size_t count, bool random = true) {
    constexpr std::uint64_t stream = 0x7a65726f73;
    const double step = length / static_cast<double>(count);
    for (std::size_t k = 0; k < count; ++k) {
      const double part = random ? unit_interval(random_bits(0, k, stream)) : 0.5;
      add(from + (static_cast<double>(k) + part) * step, step);
    }
  }

  void add(double position, double weight) {
    positions.push_back(position);
    weights.push_back(weight);
  }
};

/// Sum over samples n >= settled of the variance sum_j h_j^2 v_{n-j} of filtered independent errors of
/// variances v. As in a simulation, the first error is that of all time before it.
double filtered_scatter(const Filter& filter, const std::vector<double>& v, std::size_t settled) {
  const std::vector<double> h = impulse_response(filter, v.size());
  std::vector<double> until(v.size() + 1, 0);
  for (std::size_t n = 0; n < v.size(); ++n) until[n + 1] = until[n] + v[n];
  double sum = 0, rest = dc_gain(filter);  // of the impulse response from sample j on
  for (std::size_t j = 0; j < v.size(); ++j) {
    sum += h[j] * h[j] * (until[v.size() - j] - until[std::max(settled, j) - j]);
    if (j >= settled) sum += (rest * rest - h[j] * h[j]) * v[0];
    rest -= h[j];
  }
  return sum;
}

/// Filtered errors of one encoder at all zeros, and the sum of their squares.
class FilteredZeros {
 public:
  FilteredZeros(const Filter& filter, Zeros zeros, CountErrors count_errors)
      : zeros_(std::move(zeros)),
        count_errors_(std::move(count_errors)),
        plain_(count_errors_.plain()),
        gain_(dc_gain(filter)),
        filter_(filter, zeros_.positions.size(), batch_size),
        errors_(zeros_.positions.size() * batch_size),
        out_(errors_.size()),
        squares_(Eigen::VectorXd::Zero(std::ssize(zeros_.positions))),
        of_means_(filter, few, batch_size),
        means_(few * batch_size),
        out_of_means_(few * batch_size) {}

  /// @param x        positions at successive samples, with what displaces them [counts]
  /// @param truth    the positions themselves [counts]
  /// @param moments  of these samples
  /// @param speeds   [counts/s]
  /// @param settled  the first after the settling
  void add(const std::vector<double>& x, const std::vector<double>& truth, const std::vector<Moment>& moments,
           const std::vector<double>& speeds, std::size_t settled) {
    const std::size_t count = zeros_.positions.size();
    settled_ += settled;
    for (std::size_t i = 0; i < x.size(); ++i) {
      double* const errors = errors_.data() + i * count;
      if (plain_) {
        set_errors(x[i], errors);
        continue;
      }
      const double variance =
          count_errors_(x[i], moments[i], speeds[i], zeros_.positions, zeros_.weights, errors);
      if (count_errors_.random()) scatter_.push_back(variance);
      double mean = 0;
      for (std::size_t k = 0; k < count; ++k) mean += zeros_.weights[k] * errors[k];
      if (i >= settled) mean_ += mean;
      means_[i * few] = x[i] - truth[i] + count_errors_.mean_of_decoder(x[i], moments[i]);
      means_[i * few + 1] = mean;
    }
    if (!started_) filter_.settle(errors_.data());
    if (count_errors_.decodes()) add_means(x.size(), settled);
    started_ = true;
    filter_(errors_.data(), count, x.size(), out_.data());
    for (std::size_t i = settled; i < x.size(); ++i)
      squares_ += Eigen::Map<const Eigen::VectorXd>(out_.data() + i * count, squares_.size()).cwiseAbs2();
  }

  /// Variance over the zeros and the samples.
  /// @param samples  after the settling
  double variance(const Filter& filter, double samples) const {
    const Eigen::Map<const Eigen::VectorXd> weights(zeros_.weights.data(), squares_.size());
    double square = squares_.dot(weights) / samples;
    if (!scatter_.empty()) square += filtered_scatter(filter, scatter_, settled_) / samples;
    const double correlated = products_ / samples - first_ / samples * second_ / samples;
    return std::max(0.0, square - std::pow(gain_ * mean_ / samples, 2) + 2 * correlated);
  }

 private:
  /// Where an error within a line meets a jump of the decoder, the mean error over the zeros is not the
  /// decoder's: a signal that correlates with that of the mean path.
  void add_means(std::size_t rows, std::size_t settled) {
    if (!started_) of_means_.settle(means_.data());
    of_means_(means_.data(), few, rows, out_of_means_.data());
    for (std::size_t i = settled; i < rows; ++i) {
      const double first = out_of_means_[i * few], second = out_of_means_[i * few + 1];
      first_ += first;
      second_ += second;
      products_ += first * second;
    }
  }

  /// Errors of a quantizer at x + u: [x + u] - x - u.
  void set_errors(double x, double* errors) const {
    // The addition rounds to the nearest integer and, unlike floor, in a vector.
    constexpr double shift = 0x1.8p52;
    const double fraction = std::remainder(x, 1.0);
    const double* const zeros = zeros_.positions.data();
    for (std::size_t k = 0; k < zeros_.positions.size(); ++k) {
      const double position = fraction + zeros[k];
      errors[k] = ((position + shift) - shift) - position;
    }
  }

  Zeros zeros_;
  CountErrors count_errors_;
  bool plain_;
  double gain_, mean_ = 0;
  RowFilter filter_;
  AlignedNumbers errors_, out_;
  Eigen::VectorXd squares_;
  static constexpr std::size_t few = 8;  // channels of a row filter
  RowFilter of_means_;
  AlignedNumbers means_, out_of_means_;
  double first_ = 0, second_ = 0, products_ = 0;
  std::vector<double> scatter_;  // variance of every sample
  std::size_t settled_ = 0;      // number of samples before the end of the settling
  bool started_ = false;
};

/// Speed of every encoder, at a time [counts/s].
class Speeds {
 public:
  Speeds(const OperationalModel& model, const Motion& motion)
      : path_(motion),
        to_encoders_(model.transmission.coupling.inverse()),
        steps_(resolutions(model.transmission)) {}
  Eigen::VectorXd at(double time) const {
    return ((to_encoders_ * path_.velocity(time)).array() / steps_.array()).matrix();
  }

 private:
  MotionPath path_;
  Coupling to_encoders_;
  Eigen::VectorXd steps_;
};

/// Variances of filtered errors over the zeros and the samples of a record [counts^2]; of encoders whose
/// errors are constant `at_rest`.
Eigen::VectorXd variances_over_zeros(const OperationalModel& model, const std::vector<Effect>& effects,
                                     const Motion& motion, const Filter& filter,
                                     const UnroundedRecord& record, bool rounds, double at_rest) {
  const std::size_t encoders = model.transmission.encoders.size();
  std::vector<Effect> displacing = effects;
  std::erase_if(displacing, [](const Effect& e) { return counts_depend_on(effect_kind(e.type)); });
  const std::vector<Travel> travelled = travels(model, displacing, record);
  std::vector<std::optional<FilteredZeros>> moving(encoders);
  bool jitters = false;
  for (std::size_t e = 0; e < encoders; ++e) {
    CountErrors errors(model, effects, e, rounds);
    jitters = jitters || errors.jitters();
    const auto samples = static_cast<double>(record.filter_samples());
    if (errors.plain() && (travelled[e].range() == 0 || !rounds)) continue;
    Zeros zeros = errors.plain() ? Zeros(filter, travelled[e], samples)
                                 : Zeros(filter, errors.span(), travelled[e], samples, errors.noise(),
                                         errors.affordable());
    moving[e].emplace(filter, std::move(zeros), std::move(errors));
  }
  const Speeds speeds(model, motion);
  std::vector<double> x, truth;
  std::vector<std::vector<double>> v(encoders);
  std::vector<Moment> moments;
  record.read(model, displacing, [&](const SensedBatch& batch, const std::vector<std::size_t>& used) {
    const auto settled = static_cast<std::size_t>(std::ranges::count_if(
        used, [&](std::size_t i) { return !record.is_after_settling(batch.first + i); }));
    moments.clear();
    for (auto& of_encoder : v) of_encoder.assign(used.size(), 0);
    for (std::size_t k = 0; k < used.size(); ++k) {
      moments.push_back({.index = batch.first + used[k], .time = batch.time[used[k]]});
      if (!jitters) continue;
      const Eigen::VectorXd all = speeds.at(batch.time[used[k]]);
      for (std::size_t e = 0; e < encoders; ++e) v[e][k] = all[e];
    }
    for (std::size_t e = 0; e < encoders; ++e) {
      if (!moving[e]) continue;
      x.clear();
      truth.clear();
      for (const std::size_t i : used) {
        x.push_back(batch.measured[e * batch_size + i] / model.transmission.encoders[e].resolution);
        truth.push_back(batch.encoder[e * batch_size + i] / model.transmission.encoders[e].resolution);
      }
      moving[e]->add(x, truth, moments, v[e], settled);
    }
  });
  const auto samples = static_cast<double>(record.samples_after_settling());
  Eigen::VectorXd all = Eigen::VectorXd::Constant(encoders, at_rest);
  for (std::size_t e = 0; e < encoders; ++e)
    if (moving[e]) all[e] = moving[e]->variance(filter, samples);
  return all;
}

/// [s]. The factor 1.5 allows for the polynomial factors of repeated poles.
double settled_after(const Filter& filter) {
  const double modulus = poles_max_modulus(filter);
  const double decay = modulus > 0 ? std::log(1e-3) / std::log(modulus) : 0;
  const auto order = static_cast<double>(2 * filter.sections.size() + filter.taps.size());
  return (1.5 * decay + order) / filter.sample_rate;
}

}  // namespace

std::vector<Travel> travels(const OperationalModel& model, const std::vector<Effect>& effects,
                            const UnroundedRecord& record) {
  const std::vector<Encoder>& encoders = model.transmission.encoders;
  std::vector<Travel> all(encoders.size());
  std::vector<double> last(encoders.size());
  // Positions within a count, in parts of 2^-16: more of them need no more zeros.
  std::vector<std::bitset<65536>> seen(encoders.size());
  bool started = false;
  record.read(model, effects, [&](const SensedBatch& batch, const std::vector<std::size_t>& used) {
    for (std::size_t e = 0; e < encoders.size(); ++e) {
      Travel& t = all[e];
      for (const std::size_t i : used) {
        const double x = batch.measured[e * batch_size + i] / encoders[e].resolution;
        if (!started && i == used.front()) t = {x, x, x, 0};
        seen[e].set(static_cast<std::size_t>((x - std::floor(x)) * 0x1p16) & 0xffff);
        t.length += i == used.front() && !started ? 0 : std::abs(x - last[e]);
        t.lower = std::min(t.lower, x);
        t.upper = std::max(t.upper, x);
        last[e] = x;
      }
    }
    started = true;
  });
  for (std::size_t e = 0; e < encoders.size(); ++e) all[e].distinct = static_cast<double>(seen[e].count());
  return all;
}

std::uint64_t zeros_of_simulation(const std::vector<Travel>& travels, std::uint64_t samples) {
  constexpr double least = 16, least_crossing = 64, most_simulated = 0x1p24;
  const double most = std::clamp(most_simulated / static_cast<double>(samples), least, 256.0);
  double wanted = std::max(least, affordable_zeros(static_cast<double>(samples)));
  for (const Travel& t : travels) {
    if (t.range() == 0) continue;
    if (t.range() * most < least_crossing) return 0;
    wanted = std::max(wanted, enough_crossings * std::min(t.range(), 1.0) / t.length);
  }
  return static_cast<std::uint64_t>(std::min(wanted, most));
}

std::optional<Eigen::VectorXd> sigma_along_motion(const OperationalModel& model,
                                                  const std::vector<Effect>& effects, const Motion& motion,
                                                  const Filter& filter, double settling) {
  const UnroundedRecord record(motion, filter.sample_rate, settling);
  if (record.samples() > longest_record) return std::nullopt;
  const double constant = std::pow(dc_gain(filter), 2) / 12;
  return variances_over_zeros(model, effects, motion, filter, record, true, constant).cwiseSqrt();
}

Eigen::VectorXd sigma_within_line(const OperationalModel& model, const std::vector<Effect>& effects,
                                  const Motion& motion, const Filter& filter, double settling) {
  const UnroundedRecord record(motion, filter.sample_rate, settling);
  return variances_over_zeros(model, effects, motion, filter, record, false, 0).cwiseSqrt();
}

double settling_time(const Motion& motion, const std::vector<Filter>& filters) {
  if (motion.settling) return *motion.settling;
  double time = 0;
  for (const Filter& filter : filters) time = std::max(time, settled_after(filter));
  return std::min(time, 0.5 * motion.duration);
}

UnroundedRecord::UnroundedRecord(const Motion& motion, double rate, double settling) : motion_(motion) {
  const double ratio = motion.sample_rate / rate, whole = std::round(ratio);
  if (whole >= 1 && whole < 0x1p53 && std::abs(ratio - whole) <= 1e-9 * whole)
    every_ = static_cast<std::uint64_t>(whole);
  else
    motion_.sample_rate = rate;
  constexpr double most = 0x1p53;
  samples_ = static_cast<std::uint64_t>(
      std::clamp(std::floor(motion.duration * motion_.sample_rate + 0.5), 1.0, most));
  const std::uint64_t last = (samples_ - 1) / every_ * every_;
  settled_ = static_cast<std::uint64_t>(
      std::min(std::ceil(settling * motion_.sample_rate * (1 - 1e-12)), static_cast<double>(last)));
}

}  // namespace qerr
