#include "simulate/quantization_along_motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "filter/run/row_filter.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "simulate/decoder.hpp"

namespace qerr {

namespace {

/// Edges that all zeros together are to cross: then the mean over the zeros is within 0.2 % of its limit.
constexpr double enough_crossings = 131072;
constexpr double fewest_zeros = 32, most_zeros = 4096;

/// Zeros that a record of so many samples affords: at a whole number of counts per sample, or simple
/// fractions, a record of any length shows few positions within a count.
double affordable_zeros(double samples) { return std::min(0x1p21 / samples, 256.0); }

/// Positions of the zero over a count, with their weights in the mean.
///
/// They are equally spaced over those at which the record crosses an edge. At all others the error is a
/// constant less the motion, and its filtered square quadratic in the constant: two Gauss points are exact.
struct Zeros {
  std::vector<double> positions, weights;

  /// @param decoded  a decoder changes counts: errors of neighbouring counts differ
  Zeros(const Travel& t, double samples, bool decoded) {
    constexpr double most_evaluated = 0x1p27;
    const double most = std::clamp(most_evaluated / samples, fewest_zeros, most_zeros);
    const double crossed = decoded ? 1 : std::min(t.range(), 1.0), from = 0.5 - t.upper;
    const double wanted = std::clamp(
        std::max(enough_crossings * crossed / t.length, affordable_zeros(samples)), fewest_zeros, most);
    const auto count = static_cast<std::size_t>(wanted / 8) * 8;  // whole vectors
    const std::size_t equal = crossed < 1 ? count - 2 : count;
    const double step = crossed / static_cast<double>(equal);
    for (std::size_t k = 0; k < equal; ++k) add(from + (static_cast<double>(k) + 0.5) * step, step);
    if (crossed == 1) return;
    const double half = 0.5 * (1 - crossed), middle = from + crossed + half;
    for (const double side : {-1, 1}) add(middle + side * half / std::numbers::sqrt3, half);
  }

 private:
  void add(double position, double weight) {
    positions.push_back(std::remainder(position, 1.0));
    weights.push_back(weight);
  }
};

Decoder decoder_of(const OperationalModel& model, const std::vector<Effect>& effects, std::size_t encoder) {
  const Encoder& e = model.transmission.encoders[encoder];
  Decoder decoder{{}, direction(e)};
  for (const Effect& effect : effects) {
    const EffectKind& kind = effect_kind(effect.type);
    if (kind.stage == Stage::decoder && independent_index(model.chain, effect.joint) == encoder)
      decoder.actions.push_back(kind.action(effect, e, 0));
  }
  return decoder;
}

/// Filtered errors of one encoder at all zeros, and the sum of their squares.
class FilteredZeros {
 public:
  FilteredZeros(const Filter& filter, const Zeros& zeros, Decoder decoder)
      : zeros_(zeros),
        decoder_(std::move(decoder)),
        filter_(filter, zeros.positions.size(), batch_size),
        errors_(zeros.positions.size() * batch_size),
        out_(errors_.size()),
        squares_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(zeros.positions.size()))) {}

  /// @param x        positions at successive samples [counts]
  /// @param moments  of these samples
  /// @param settled  the first after the settling
  void add(const std::vector<double>& x, const std::vector<Moment>& moments, std::size_t settled) {
    const std::size_t count = zeros_.positions.size();
    for (std::size_t i = 0; i < x.size(); ++i) {
      double* const errors = errors_.data() + i * count;
      decoder_.empty() ? set_errors(x[i], errors) : set_decoded_errors(x[i], moments[i], errors);
    }
    if (!started_) filter_.settle(errors_.data());
    started_ = true;
    filter_(errors_.data(), count, x.size(), out_.data());
    for (std::size_t i = settled; i < x.size(); ++i)
      squares_ += Eigen::Map<const Eigen::VectorXd>(out_.data() + i * count, squares_.size()).cwiseAbs2();
  }

  /// Mean over the zeros of the sum of the squares.
  double mean() const {
    return squares_.dot(Eigen::Map<const Eigen::VectorXd>(zeros_.weights.data(), squares_.size()));
  }

 private:
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

  /// Errors behind a decoder D: D([x + u]) - x - u, less their mean over u.
  void set_decoded_errors(double x, const Moment& m, double* errors) const {
    const double mean = decoder_.mean(x, m);
    for (std::size_t k = 0; k < zeros_.positions.size(); ++k) {
      const double u = zeros_.positions[k];
      errors[k] = decoder_(std::round(x + u), m) - u - mean;
    }
  }

  Zeros zeros_;
  Decoder decoder_;
  RowFilter filter_;
  AlignedNumbers errors_, out_;
  Eigen::VectorXd squares_;
  bool started_ = false;
};

}  // namespace

std::vector<Travel> travels(const OperationalModel& model, const std::vector<Effect>& effects,
                            const UnroundedRecord& record) {
  const std::vector<Encoder>& encoders = model.transmission.encoders;
  std::vector<Travel> all(encoders.size());
  std::vector<double> last(encoders.size());
  bool started = false;
  record.read(model, effects, [&](const SensedBatch& batch, const std::vector<std::size_t>& used) {
    for (std::size_t e = 0; e < encoders.size(); ++e) {
      Travel& t = all[e];
      for (const std::size_t i : used) {
        const double x = batch.measured[e * batch_size + i] / encoders[e].resolution;
        if (!started && i == used.front()) t = {x, x, x, 0};
        t.length += i == used.front() && !started ? 0 : std::abs(x - last[e]);
        t.lower = std::min(t.lower, x);
        t.upper = std::max(t.upper, x);
        last[e] = x;
      }
    }
    started = true;
  });
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
  const std::vector<Encoder>& encoders = model.transmission.encoders;
  std::vector<Effect> before_decoders = effects;
  std::erase_if(before_decoders, [](const Effect& e) { return effect_kind(e.type).stage == Stage::decoder; });
  const std::vector<Travel> travelled = travels(model, before_decoders, record);
  std::vector<std::optional<FilteredZeros>> moving(encoders.size());
  for (std::size_t e = 0; e < encoders.size(); ++e) {
    const Decoder decoder = decoder_of(model, effects, e);
    const bool decoded = !decoder.empty();
    if (travelled[e].range() == 0 && !decoded) continue;
    moving[e].emplace(filter, Zeros(travelled[e], static_cast<double>(record.filter_samples()), decoded),
                      decoder);
  }
  std::vector<double> x;
  std::vector<Moment> moments;
  record.read(model, before_decoders, [&](const SensedBatch& batch, const std::vector<std::size_t>& used) {
    const auto settled = static_cast<std::size_t>(std::count_if(
        used.begin(), used.end(), [&](std::size_t i) { return !record.is_after_settling(batch.first + i); }));
    moments.clear();
    for (const std::size_t i : used) moments.push_back({.index = batch.first + i, .time = batch.time[i]});
    for (std::size_t e = 0; e < encoders.size(); ++e) {
      if (!moving[e]) continue;
      x.clear();
      for (const std::size_t i : used)
        x.push_back(batch.measured[e * batch_size + i] / encoders[e].resolution);
      moving[e]->add(x, moments, settled);
    }
  });
  const double gain = dc_gain(filter);
  Eigen::VectorXd sigma(static_cast<Eigen::Index>(encoders.size()));
  for (std::size_t e = 0; e < encoders.size(); ++e) {
    const double square = moving[e] ? moving[e]->mean() / static_cast<double>(record.samples_after_settling())
                                    : gain * gain / 12;
    sigma[static_cast<Eigen::Index>(e)] = std::sqrt(square);
  }
  return sigma;
}

}  // namespace qerr
