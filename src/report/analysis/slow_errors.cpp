#include "report/analysis/slow_errors.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "filter/run/cascade.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "qerr/encoder/encoder_kinds.hpp"
#include "report/analysis/effects.hpp"
#include "simulate/motion_path.hpp"
#include "simulate/settling.hpp"
#include "simulate/unrounded_record.hpp"

namespace qerr {

namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
constexpr double gear_periods = 2;  ///< of a gear's error in a revolution of its fast shaft

/// Periods of a sine of the shaft per unit of the encoder's coordinate [1/rad or 1/m]; empty: not known.
std::optional<double> periods_per_unit(const Spec& spec, std::size_t encoder, const RobotUsage& usage) {
  const bool shaft = encoder_kind(spec.encoder_figures[encoder].kind).counts_per_rev ||
                     !spec.model.chain.independent[encoder].prismatic();
  if (shaft) return std::abs(spec.model.transmission.encoders[encoder].shaft_ratio) / (2 * std::numbers::pi);
  const auto& position = usage.encoders[encoder].position;
  if (!position || !(position->half_width() > 0)) return std::nullopt;
  return 0.5 / position->half_width();
}

/// Root mean square of |H| over the frequencies from 0 to `highest`.
double mean_response(const Filter& filter, double highest) {
  constexpr int intervals = 512;  // |H|^2 of orders up to 8 is smooth on a 512th of the band
  double sum = 0;
  for (int i = 0; i < intervals; ++i) sum += std::norm(response(filter, highest * (i + 0.5) / intervals));
  return std::sqrt(sum / intervals);
}

/// Root mean square of a filtered exp(j 2 pi periods x) along the motion: of sqrt(2) sin with any phase.
double response_along(const Spec& spec, std::size_t encoder, const Filter& filter, double periods) {
  const double settling = settling_time(*spec.motion, designed_filters(spec));
  const double samples = std::floor(spec.motion->duration * filter.sample_rate + 0.5);
  if (!(samples >= 1 && samples <= static_cast<double>(longest_record))) return unknown;
  const MotionPath path(*spec.motion);
  const Eigen::RowVectorXd to_encoder =
      spec.model.transmission.coupling.inverse().row(static_cast<Eigen::Index>(encoder));
  // From the steady state for the first reading: zero states would add its step.
  Cascade<double> cosine(filter), sine(filter);
  const double at_start = to_encoder.dot(path.position(0));
  double sum = 0, counted = 0;
  for (double k = 0; k < samples; ++k) {
    const double x =
        2 * std::numbers::pi * periods * (to_encoder.dot(path.position(k / filter.sample_rate)) - at_start);
    const double constant = filter.derivative == 0 ? 0 : 1;
    const double c = cosine.step(std::cos(x) - constant), s = sine.step(std::sin(x));
    if (k / filter.sample_rate < settling) continue;
    sum += c * c + s * s;
    ++counted;
  }
  return counted > 0 ? std::sqrt(sum / counted) : unknown;
}

}  // namespace

SlowErrorRatios slow_error_ratios(const Spec& spec) {
  const auto& encoders = spec.model.transmission.encoders;
  const std::vector<double> none(spec.filters.size(), unknown);
  SlowErrorRatios ratios{SigmaRatios(encoders.size(), none), SigmaRatios(encoders.size(), none)};
  if (!states_accuracy(spec) || spec.filters.empty()) return ratios;
  const RobotUsage usage = usage_of(spec);
  for (std::size_t i = 0; i < encoders.size(); ++i) {
    const std::optional<double> periods = periods_per_unit(spec, i, usage);
    const auto& velocity = usage.encoders[i].velocity;
    if (!periods || !velocity) continue;
    const auto ratio = [&](const Filter& filter, double of_shaft) {
      return spec.motion ? response_along(spec, i, filter, of_shaft * *periods)
                         : mean_response(filter, of_shaft * *periods * velocity->largest());
    };
    for (std::size_t f = 0; f < spec.filters.size(); ++f) {
      if (encoders[i].accuracy > 0) ratios.accuracy[i][f] = ratio(spec.filters[f].filter, 1);
      if (encoders[i].gear_accuracy > 0)
        ratios.gear_accuracy[i][f] = ratio(spec.filters[f].filter, gear_periods);
    }
  }
  return ratios;
}

std::vector<double> step_energies(const std::vector<Filter>& filters) {
  std::vector<double> energies;
  for (const Filter& filter : filters) {
    constexpr double most = 1e6, left = 1e-9;
    const double modulus = poles_max_modulus(filter);
    const double memory = modulus > 0 ? std::log(left) / std::log(modulus) : 0;
    double& energy = energies.emplace_back(unknown);
    const double count = memory + static_cast<double>(filter.taps.size() + filter.sections.size()) + 8;
    if (filter.derivative == 0 || !(count < most)) continue;
    double step = 0, sum = 0, largest = 0;
    for (const double h : impulse_response(filter, static_cast<std::size_t>(count))) {
      step += h;
      largest = std::max(largest, std::abs(step));
      sum += step * step;
    }
    if (std::abs(step) <= 1e-6 * largest) energy = sum / filter.sample_rate;
  }
  return energies;
}

std::string slow_error_assumption(const Spec& spec, const std::vector<EffectShare>& effects) {
  if (spec.filters.empty()) return "";
  const bool play = !spec.motion && std::any_of(effects.begin(), effects.end(), [](const EffectShare& e) {
    return e.included && e.reversals.has_value();
  });
  std::string text;
  if (states_accuracy(spec))
    text =
        "an encoder's `accuracy` as a sine of one period a revolution of its shaft (of a gear: two; of a "
        "scale: one over the range)";
  if (play) text += std::string(text.empty() ? "" : ", ") + "play as a step at each end of the joint's range";
  if (text.empty()) return "";
  return "sigma behind a filter takes " + text +
         (spec.motion ? ", along `motion:`"
                      : ", at speeds from 0 to the URDF's limits; add `motion:` to get it at yours");
}

}  // namespace qerr
