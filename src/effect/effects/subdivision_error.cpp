#include <algorithm>
#include <cmath>
#include <numbers>

#include "effect/effects/effects.hpp"

namespace qerr {

namespace {

constexpr double turn = 2 * std::numbers::pi;

/// Electrical angle that atan2 gives for distorted signals (Heydemann 1981), less the true one, in (-pi, pi].
class Distortion {
 public:
  explicit Distortion(const Effect& e)
      : offset_sin_(e.number("offset_sin")),
        offset_cos_(e.number("offset_cos")),
        gain_(1 + e.number("gain")),
        phase_(e.number("phase")),
        clip_(e.number("clipping")),
        ideal_(offset_sin_ == 0 && offset_cos_ == 0 && gain_ == 1 && phase_ == 0 && clip_ >= 1) {}

  double operator()(double angle) const {
    if (ideal_) return 0;
    const double sine = limited(gain_ * std::sin(angle + phase_) + offset_sin_);
    const double cosine = limited(std::cos(angle) + offset_cos_);
    return std::remainder(std::atan2(sine, cosine) - angle, turn);
  }

 private:
  double limited(double x) const { return clip_ < 1 ? std::clamp(x, -clip_, clip_) : x; }

  double offset_sin_, offset_cos_, gain_, phase_, clip_;
  bool ideal_;
};

double period(const Encoder& encoder) { return encoder.resolution * encoder.counts_per_period; }

constexpr int points = 4096, harmonics = 24;

/// Parts of the variance at 1, 2, ... periods per period of the lines.
std::vector<Wave> waves(const std::vector<double>& errors, double variance, double unit) {
  std::vector<Wave> found;
  for (int k = 1; k <= harmonics; ++k) {
    double sine = 0, cosine = 0;
    for (int i = 0; i < points; ++i) {
      const double angle = turn * ((k * i) % points) / points;
      sine += errors[static_cast<std::size_t>(i)] * std::sin(angle);
      cosine += errors[static_cast<std::size_t>(i)] * std::cos(angle);
    }
    const double power = 2 * (sine * sine + cosine * cosine) / (double{points} * points);
    if (power > 1e-6 * variance) found.push_back({k / unit, power / variance});
  }
  return found;
}

std::optional<Share> share(const Effect& e, const Encoder& encoder, const Usage&) {
  const Distortion distortion(e);
  std::vector<double> errors;
  double sum = 0, squares = 0, low = 0, high = 0, between = 0;
  for (int i = 0; i < points; ++i) {
    const double before = i == 0 ? distortion(0) : errors.back();
    const double error = errors.emplace_back(distortion(turn * i / points));
    between = std::max(between, 0.5 * std::abs(error - before));  // a peak may lie between two points
    sum += error;
    squares += error * error;
    low = std::min(low, error);
    high = std::max(high, error);
  }
  if (squares == 0) return Share{};
  const double unit = period(encoder) / turn, mean = sum / points;
  const double variance = std::max(0.0, squares / points - mean * mean);
  return Share{mean * unit, (std::max(high - mean, mean - low) + between) * unit, std::sqrt(variance) * unit,
               Course::travel, waves(errors, variance, unit)};
}

}  // namespace

EffectKind subdivision_error_effect() {
  return {"subdivision_error",
          "sine and cosine of a line with offset, gain and phase errors, or clipped",
          "within 1 % of a signal period (HEIDENHAIN); resolvers 1.5 deg at 5 % of gain, 8 deg when clipped "
          "at 0.65",
          Stage::line,
          {{.name = "offset_sin",
            .meaning = "offset of the sine over its amplitude",
            .fallback = 0.0,
            .least = -1,
            .most = 1},
           {.name = "offset_cos",
            .meaning = "offset of the cosine over its amplitude",
            .fallback = 0.0,
            .least = -1,
            .most = 1},
           {.name = "gain",
            .meaning = "amplitude of the sine over that of the cosine, minus 1",
            .fallback = 0.0,
            .least = -1,
            .most = 1},
           {.name = "phase",
            .dimension = dimension::angle,
            .meaning = "error of the right angle between them, electrical",
            .fallback = 0.0},
           {.name = "clipping",
            .meaning = "level at which both are clipped, over their amplitude; 1: not at all",
            .fallback = 1.0,
            .least = 0,
            .most = 1,
            .open_below = true}},
          [](const Effect& e, const Encoder& encoder, std::uint64_t) -> Action {
            return [distortion = Distortion(e), unit = period(encoder) / turn](double x, const Moment&) {
              return x + unit * distortion(std::remainder(x / unit, turn));
            };
          },
          share};
}

}  // namespace qerr
