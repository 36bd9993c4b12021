#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "effect/effects/effects.hpp"
#include "effect/effects/periodic.hpp"

namespace qerr {

namespace {

constexpr double turn = 2 * std::numbers::pi;

/// Electrical angle that atan2 gives for distorted signals (Heydemann 1981), minus the true one, in (-pi,
/// pi].
class Distortion {
 public:
  explicit Distortion(const Effect& e)
      : offset_sin_(e.number("offset_sin")),
        offset_cos_(e.number("offset_cos")),
        sin_phase_(std::sin(e.number("phase"))),
        cos_phase_(std::cos(e.number("phase"))),
        gain_(1 + e.number("gain")),
        clip_(e.number("clipping")),
        ideal_(offset_sin_ == 0 && offset_cos_ == 0 && gain_ == 1 && sin_phase_ == 0 && clip_ >= 1) {}

  double operator()(double angle) const { return at(std::sin(angle), std::cos(angle)); }

  /// At the angle with this sine and cosine; the difference of the two angles is one arctangent of their
  /// cross and dot product.
  double at(double s, double c) const {
    if (ideal_) return 0;
    const double sine = limited(sine_signal(s, c)), cosine = limited(c + offset_cos_);
    return std::atan2(sine * c - cosine * s, cosine * c + sine * s);
  }

  /// Derivatives with respect to the coefficients, in their order.
  std::array<double, 5> gradient(double s, double c) const {
    const double raw_sine = sine_signal(s, c), raw_cosine = c + offset_cos_;
    const double sine = limited(raw_sine), cosine = limited(raw_cosine);
    const double square = std::max(sine * sine + cosine * cosine, 1e-12);
    const double by_sine = cosine / square, by_cosine = -sine / square;
    const double if_free = is_free(raw_sine) ? by_sine : 0;
    return {if_free, is_free(raw_cosine) ? by_cosine : 0, if_free * (cos_phase_ * s + sin_phase_ * c),
            if_free * gain_ * (cos_phase_ * c - sin_phase_ * s),
            by_sine * clipped(raw_sine) + by_cosine * clipped(raw_cosine)};
  }

 private:
  double sine_signal(double s, double c) const {
    return gain_ * (cos_phase_ * s + sin_phase_ * c) + offset_sin_;
  }
  double limited(double x) const { return clip_ < 1 ? std::clamp(x, -clip_, clip_) : x; }
  bool is_free(double x) const { return clip_ >= 1 || std::abs(x) < clip_; }
  /// Derivative of a signal with respect to the level. Peaks just below it count, else a fit that has reached
  /// 1 would have no way back.
  double clipped(double x) const { return std::abs(x) < clip_ - 1e-4 ? 0 : std::copysign(1.0, x); }

  double offset_sin_, offset_cos_, sin_phase_, cos_phase_, gain_, clip_;
  bool ideal_;
};

double period(const Encoder& encoder) { return encoder.resolution * encoder.counts_per_period; }

constexpr std::string_view lissajous = "the raw sine and cosine of the encoder (their Lissajous figure)";

constexpr int points = 4096;

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
               Spectrum::motion};
}

Action action(const Effect& e, const Encoder& encoder, std::uint64_t) {
  return [distortion = Distortion(e), unit = period(encoder) / turn](double x, const Moment&) {
    return x + unit * distortion(x / unit);
  };
}

// The regression's coefficients, in this order; the last one only of signals that are clipped.
constexpr std::array<const char*, 5> coefficients{"offset_sin", "offset_cos", "gain", "phase", "clipping"};
constexpr Eigen::Index clipping = 4;

/// Intermediate parameters of a fit, limited to the range in which the effect is defined.
Eigen::VectorXd limited(Eigen::VectorXd p) {
  constexpr double most = 0.9, least_clipping = 0.2;
  for (Eigen::Index i = 0; i < p.size(); ++i)
    p[i] = i == clipping ? std::clamp(p[i], least_clipping, 1.0) : std::clamp(p[i], -most, most);
  return p;
}

void fill(Effect& e, const Eigen::VectorXd& values) {
  const Eigen::VectorXd p = limited(values);
  e.numbers["clipping"] = 1;
  for (Eigen::Index i = 0; i < p.size(); ++i) e.numbers[coefficients[i]] = p[i];
}

/// The term linearized about parameters.
Term linearized(const RecordSignals& s, const Term& t, const Eigen::VectorXd& values) {
  Term next = t;
  const Eigen::VectorXd p = limited(values);
  Effect effect = t.effect;
  fill(effect, p);
  next.effect = effect;
  const Distortion distortion(effect);
  const double unit = period(s.encoder) / turn;  // [rad or m] per electrical radian
  next.columns.resize(s.rows(), p.size());
  next.fixed.resize(p.isZero() ? 0 : s.rows());
  for (Eigen::Index row = 0; row < s.rows(); ++row) {
    const double angle = (t.moved.size() > 0 ? s.path[row] + t.moved[row] : s.path[row]) / unit;
    const double sine = std::sin(angle), cosine = std::cos(angle);
    const std::array<double, 5> gradient = distortion.gradient(sine, cosine);
    double linear = 0;
    for (Eigen::Index i = 0; i < p.size(); ++i) {
      next.columns(row, i) = unit * gradient[i];
      linear += next.columns(row, i) * p[i];
    }
    if (next.fixed.size() > 0) next.fixed[row] = unit * distortion.at(sine, cosine) - linear;
  }
  return next;
}

/// Linearized about the parameters that the term has.
Term along(const RecordSignals& s, const Term& t, const Eigen::ArrayXd& moved) {
  Term next = t;
  next.moved = moved;
  Eigen::VectorXd p(t.size());
  for (Eigen::Index i = 0; i < p.size(); ++i) p[i] = t.effect.number(coefficients[i]);
  return linearized(s, next, p);
}

/// Offsets, gain and phase (Heydemann) of signals that are not clipped, and of clipped ones.
std::vector<Term> terms(const RecordSignals& s) {
  if (s.is_stationary() || s.encoder.counts_per_period <= 4) return {};
  Term t;
  t.effect = {"subdivision_error", s.joint, {{"clipping", 1.0}}, {}};
  t.fill = fill;
  t.relinearized = linearized;
  t.along = along;
  Eigen::VectorXd p = Eigen::VectorXd::Zero(coefficients.size());
  std::vector<Term> all{linearized(s, t, p.head(clipping))};
  // The fit converges from a linearization near its optimum: one level at which clipping is just visible, and
  // one of the resolvers in the catalogue of diagnosis.
  for (const double level : {0.95, 0.75}) {
    p[clipping] = level;
    all.push_back(linearized(s, t, p));
  }
  return all;
}

bool has_one_unclipped_period(const Effect& e, const RecordSignals& s) {
  return has_one_period(s.encoder) && e.number("clipping") == 1;
}

}  // namespace

EffectKind subdivision_error_effect() {
  return {.name = "subdivision_error",
          .summary = "sine and cosine of a line with offset, gain and phase errors, or clipped",
          .typical =
              "within 1 % of a signal period (HEIDENHAIN); resolvers 1.5 deg at 5 % of gain, 8 deg when "
              "clipped at 0.65",
          .stage = Stage::line,
          .parameters = {{.name = "offset_sin",
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
                          .meaning = "deviation of their phase difference from 90 deg, electrical",
                          .fallback = 0.0},
                         {.name = "clipping",
                          .meaning = "level at which both are clipped, over their amplitude; 1: no clipping",
                          .fallback = 1.0,
                          .least = 0,
                          .most = 1,
                          .open_below = true}},
          .action = action,
          .share = share,
          .encoder_need =
              EncoderNeed{.least = 4,
                          .why = "it has no interpolation within a signal period",
                          .remedy = "an interpolated encoder (see `qerr list encoders`), or decoding: x4",
                          .period_must_be_given = true},
          .terms = terms,
          // Within one period of a resolver, offset and gain make orders 1 and 2 of its shaft.
          .twins = {{"eccentricity", {}, has_one_unclipped_period},
                    {"compliance", lissajous},
                    {"drift", lissajous}},
          .record = lissajous,
          .table = TableShape{.period = [](const Effect&, const Encoder& e) { return period(e); },
                              .points_per_period = 256},
          .remedy = {true, "adjust offset, gain and phase of the signals, or use the look-up table"}};
}

}  // namespace qerr
