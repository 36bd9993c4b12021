#include "simulate/count_errors.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/search.hpp"
#include "effect/action_path.hpp"

namespace qerr {

const std::vector<double>& normal_values() {
  static const std::vector<double> values = [] {
    constexpr int count = 64;
    std::vector<double> v;
    double square = 0;
    for (int i = 0; i < count; ++i) {
      const auto below = [&](double x) {
        return 0.5 * std::erfc(-x / std::numbers::sqrt2) < (i + 0.5) / count;
      };
      v.push_back(bisect({-8, 8}, 60, below).holds);
      square += v.back() * v.back() / count;
    }
    for (double& x : v) x /= std::sqrt(square);
    return v;
  }();
  return values;
}

double Decoder::mean_over_zero(double position, const Moment& m) const {
  const double below = std::floor(position), part = position - below, decoded = (*this)(below, m);
  return part == 0 ? decoded : decoded + part * ((*this)(below + 1, m) - decoded);
}

double Decoder::mean(double position, const Moment& m) const {
  if (noise == 0) return mean_over_zero(position, m);
  double sum = 0;
  for (const double value : normal_values()) sum += mean_over_zero(position + noise * value, m);
  return sum / static_cast<double>(normal_values().size());
}

bool counts_depend_on(const EffectKind& kind) {
  return (kind.stage >= Stage::line && kind.stage <= Stage::decoder) || kind.random();
}

namespace {

constexpr std::size_t parts = 512;  // of a count

/// P(N > t) of a standard normal N.
double above(double t) { return 0.5 * std::erfc(t / std::numbers::sqrt2); }

/// Below this noise only the nearest edge matters: the next one is at least 10 standard deviations away.
constexpr double one_edge = 0.05;
/// From this noise on, the rounding error is independent of y: its first harmonic is exp(-32 pi^2).
constexpr double no_edge = 4;

}  // namespace

DitheredRounding::DitheredRounding(double s) : s_(s) {
  if (s < one_edge || s >= no_edge) return;
  for (std::size_t i = 0; i <= parts; ++i) {
    const double y = static_cast<double>(i) / parts;
    double mean = 0, square = 0;
    for (int j = 0; j <= 2 + 7 * s; ++j) {
      const double up = above((j + 0.5 - y) / s), down = above((j + 0.5 + y) / s);
      mean += up - down;
      square += (2 * j + 1) * (up + down);
    }
    table_.push_back({mean - y, square - mean * mean});
  }
}

DitheredRounding::Moments DitheredRounding::operator()(double y) const {
  const double part = y - std::floor(y);
  if (s_ >= no_edge) return {0, s_ * s_ + 1 / 12.0};
  if (s_ < one_edge) {
    const double distance = (part - 0.5) / s_;
    constexpr double certain = 9;  // standard deviations
    if (std::abs(distance) > certain) return {(distance > 0 ? 1 : 0) - part, 0};
    const double up = above(-distance);
    return {up - part, up * (1 - up)};
  }
  const double row = part * parts;
  const auto i = std::min(static_cast<std::size_t>(row), parts - 1);
  const double after = row - static_cast<double>(i);
  const Moments &low = table_[i], &high = table_[i + 1];
  return {low.error + after * (high.error - low.error),
          low.variance + after * (high.variance - low.variance)};
}

CountErrors::CountErrors(const OperationalModel& model, const std::vector<Effect>& effects,
                         std::size_t encoder, bool rounds)
    : rounds_(rounds), adds_jitter_(model.transmission.coupling.is_identity()) {
  Encoder e = model.transmission.encoders[encoder];
  const auto of_encoder = [&](const Effect& effect) {
    return independent_index(model.chain, effect.joint) == encoder;
  };
  std::vector<Action> line;
  // What the decoder makes of it is counted below.
  double of_disc = 1;
  for (const Effect& effect : effects)
    if (of_encoder(effect) && effect_kind(effect.type).stage == Stage::disc)
      of_disc *= multiplied_behind(Stage::clock, effect.joint, {effect}, e);
  for (const Effect& effect : effects)
    if (const auto modify = effect_kind(effect.type).modify_encoder; modify && of_encoder(effect)) modify(e);
  for (const Effect& effect : effects) {
    const EffectKind& kind = effect_kind(effect.type);
    if (!counts_depend_on(kind) || !of_encoder(effect)) continue;
    if (kind.random() && kind.stage == Stage::clock)
      jitter_ = std::hypot(jitter_, effect.number("sigma") * std::abs(of_disc));
    else if (kind.random())
      noise_ = std::hypot(noise_, effect.number("sigma") / e.resolution);
    else if (kind.stage == Stage::line)
      line.push_back(kind.action(effect, e, 0));
    else if (kind.stage == Stage::decoder && rounds)
      decoder_.actions.push_back(kind.action(effect, e, 0));
  }
  decoder_.sign = direction(e);
  decoder_.noise = noise_;
  decoder_shift_ = below_reading(e) - below_reading(model.transmission.encoders[encoder]);
  if (!line.empty() || !decoder_.empty()) shift_ = below_reading(e) - 0.5;
  if (line.empty()) return;
  span_ = e.counts_per_period;
  constexpr double least = 16384, most = 262144, per_count = 64;
  const auto rows = static_cast<std::size_t>(std::clamp(per_count * span_, least, most));
  for (std::size_t i = 0; i <= rows; ++i) {
    const double position = span_ * static_cast<double>(i) / static_cast<double>(rows);
    double x = position * e.resolution;
    for (Action& action : line) x = action(x, {});
    line_.push_back(x / e.resolution - position);
  }
}

double CountErrors::affordable() const {
  if (decoder_.empty()) return line_.empty() || jitter_ == 0 ? 0x1p25 : 0x1p22;  // a table for every slope
  return random() ? 0x1p20 : 0x1p24;
}

CountErrors::Distorted CountErrors::distortion(double position) const {
  if (line_.empty()) return {0, 0};
  const auto rows = static_cast<double>(line_.size() - 1);
  const double part = position / span_, row = (part - std::floor(part)) * rows;
  const auto i = std::min(static_cast<std::size_t>(row), line_.size() - 2);
  const double rise = line_[i + 1] - line_[i];
  return {line_[i] + (row - static_cast<double>(i)) * rise, rise * rows / span_};
}

const DitheredRounding& CountErrors::rounding(double s) {
  // In steps of 1 %: the variance is at most proportional to s^2.
  constexpr double per_step = 0.01;
  const int step = static_cast<int>(std::lround(std::log(s) / per_step));
  const auto found = roundings_.find(step);
  if (found != roundings_.end()) return found->second;
  return roundings_
      .emplace(step, DitheredRounding(noise_ > 0 && jitter_ == 0 ? s : std::exp(per_step * step)))
      .first->second;
}

/// Mean and variance of the decoded count less w, over noise of standard deviation s.
std::pair<double, double> CountErrors::decoded(double w, double y, double s, double u,
                                               const Moment& m) const {
  // The decoder counts from a zero within a count: u moves the line, and the counter only by its fraction.
  const double whole = std::round(u);
  const auto error = [&](double position) {
    const double n = std::round(position) - whole;
    return decoder_(n, m) + whole - w;
  };
  if (s == 0) return {error(y), 0};
  double mean = 0, square = 0;
  for (const double value : normal_values()) {
    const double e = error(y + s * value);
    mean += e;
    square += e * e;
  }
  const auto count = static_cast<double>(normal_values().size());
  mean /= count;
  return {mean, std::max(0.0, square / count - mean * mean)};
}

double CountErrors::operator()(double x, const Moment& m, double speed, const std::vector<double>& zeros,
                               const std::vector<double>& weights, double* errors) {
  const double of_decoder = mean_of_decoder(x, m);
  const double jitter = jitter_ * std::abs(speed);
  const DitheredRounding* rounding = nullptr;
  double before = -1, variance = 0;
  for (std::size_t k = 0; k < zeros.size(); ++k) {
    const double w = x + zeros[k];
    const Distorted d = distortion(w);
    if (!rounds_) {
      errors[k] = d.by;
      continue;
    }
    const double y = w + d.by + shift_, s = std::hypot(noise_, (1 + d.slope) * jitter);
    if (!decoder_.empty()) {
      const auto [mean, scatter] = decoded(w, y, s, zeros[k], m);
      errors[k] = mean - of_decoder;
      variance += weights[k] * scatter;
    } else if (s == 0) {
      errors[k] = std::round(y) - w;
    } else {
      if (s != before) rounding = &this->rounding(s);
      before = s;
      const DitheredRounding::Moments rounded = (*rounding)(y);
      errors[k] = rounded.error + (y - w);
      variance += weights[k] * rounded.variance;
    }
  }
  return adds_jitter_ ? variance : std::max(0.0, variance - jitter * jitter);
}

}  // namespace qerr
