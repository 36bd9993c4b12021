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
    return x + unit * distortion(std::remainder(x / unit, turn));
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
  for (Eigen::Index i = 0; i < p.size(); ++i) e.numbers[coefficients[static_cast<std::size_t>(i)]] = p[i];
}

/// Error along the path at parameters p.
Eigen::ArrayXd added(const RecordSignals& s, const Term& t, const Eigen::VectorXd& p) {
  Effect effect = t.effect;
  fill(effect, p);
  const Action distorted = action(effect, s.encoder, 0);
  const Eigen::ArrayXd path = t.moved.size() > 0 ? Eigen::ArrayXd(s.path + t.moved) : s.path;
  return path.unaryExpr([&](double x) { return distorted(x, {}) - x; });
}

/// The term linearized about parameters, by central differences.
Term linearized(const RecordSignals& s, const Term& t, const Eigen::VectorXd& values) {
  constexpr double change = 1e-4;
  Term next = t;
  const Eigen::VectorXd p = limited(values);
  next.columns.resize(s.rows(), p.size());
  for (Eigen::Index i = 0; i < p.size(); ++i) {
    const Eigen::VectorXd step = change * Eigen::VectorXd::Unit(p.size(), i);
    // The difference is one-sided at clipping = 1.
    const Eigen::VectorXd upper = i == clipping && p[i] + change > 1 ? p : Eigen::VectorXd(p + step);
    next.columns.col(i) = (added(s, t, upper) - added(s, t, p - step)) / (upper[i] - p[i] + change);
  }
  if (!p.isZero()) next.fixed = added(s, t, p) - (next.columns.matrix() * p).array();
  return next;
}

/// The linearization is renewed after each fit anyway: only the path's displacement is stored.
Term along(const RecordSignals&, const Term& t, const Eigen::ArrayXd& moved) {
  Term next = t;
  next.moved = moved;
  return next;
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
