#include <cmath>

#include "effect/effects/effects.hpp"

namespace qerr {

namespace {

/// amplitude (1 - exp(-t/time_constant)) + coefficient * temperature rise.
Action action(const Effect& e, const Encoder&, std::uint64_t) {
  return [amplitude = e.number("amplitude"), constant = e.number("time_constant"),
          coefficient = e.number("coefficient")](double x, const Moment& m) {
    const double risen = constant > 0 ? -std::expm1(-m.time / constant) : 1;
    return x + amplitude * risen + coefficient * m.temperature_rise;
  };
}

/// Spread evenly between nothing and all of it, as nobody knows when; with no time constant it is an offset.
std::optional<Share> share(const Effect& e, const Encoder&, const Usage& u) {
  const double amplitude = e.number("amplitude");
  Share s{amplitude, 0, 0};
  if (e.number("time_constant") > 0)
    s = {0.5 * amplitude, 0.5 * std::abs(amplitude), std::abs(amplitude) / std::sqrt(12.0)};
  const auto by_temperature = proportional(e.number("coefficient"), u.temperature);
  if (!by_temperature) return std::nullopt;
  s.mean += by_temperature->mean;
  s.half_width += by_temperature->half_width;
  s.sigma += by_temperature->sigma;  // both rise with time: not independent
  return s;
}

}  // namespace

EffectKind drift_effect() {
  return {"drift",
          "slow change in time or with temperature",
          "0.1 mm on half a metre of aluminium and 10 K, over minutes to hours",
          Stage::disc,
          {{.name = "amplitude", .meaning = "final size", .fallback = 0.0, .coordinate = true},
           {.name = "time_constant",
            .dimension = dimension::time,
            .meaning = "of its exponential approach; none: at once",
            .least = 0,
            .open_below = true},
           {.name = "coefficient",
            .dimension = dimension::angle_per_temperature,
            .meaning = "change per kelvin, with a temperature column",
            .fallback = 0.0}},
          action,
          share,
          Need::temperature};
}

}  // namespace qerr
