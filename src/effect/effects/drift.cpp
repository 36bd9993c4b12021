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

/// Uniform between zero and the amplitude, as the time since its start is unknown; an offset without a time
/// constant.
std::optional<Share> share(const Effect& e, const Encoder&, const Usage& u) {
  const double amplitude = e.number("amplitude");
  Share s{amplitude, 0, 0};
  if (e.number("time_constant") > 0)
    s = {0.5 * amplitude, 0.5 * std::abs(amplitude), std::abs(amplitude) / std::sqrt(12.0), Spectrum::motion};
  const auto of_temperature = proportional(e.number("coefficient"), u.temperature);
  if (!of_temperature) return std::nullopt;
  s.mean += of_temperature->mean;
  s.half_width += of_temperature->half_width;
  s.sigma += of_temperature->sigma;  // both rise with time: not independent
  return s;
}

Term exponential_term(const RecordSignals& s, double time_constant) {
  Term t = linear_term(s, "drift", 1 - (-s.time / time_constant).exp(),
                       [](Effect& e, const Eigen::VectorXd& c) { e.numbers["amplitude"] = c[0]; });
  t.effect.numbers["time_constant"] = t.shape = time_constant;
  t.half_width = 0.7 * time_constant;
  t.reshaped = [](const RecordSignals& record, const Term&, double shape) {
    return exponential_term(record, shape);
  };
  return t;
}

std::vector<Term> terms(const RecordSignals& s) {
  if (!s.ordered) return {};
  const double duration = s.time[s.rows() - 1];
  std::vector<Term> all;
  for (const double part : {0.1, 0.3, 1.0}) all.push_back(exponential_term(s, part * duration));
  if (s.temperature.size() > 0)
    all.push_back(linear_term(s, "drift", s.temperature,
                              [](Effect& e, const Eigen::VectorXd& c) { e.numbers["coefficient"] = c[0]; }));
  return all;
}

/// A planned record has no temperatures.
std::optional<MissingSignal> missing_signal(const RecordSignals& s) {
  if (s.temperature.size() > 0) return std::nullopt;
  return MissingSignal{"drift with the temperature", "the column " + s.joint + ".temperature"};
}

}  // namespace

EffectKind drift_effect() {
  return {.name = "drift",
          .summary = "slow change in time or with temperature",
          .typical = "0.1 mm on half a metre of aluminium and 10 K, over minutes to hours",
          .stage = Stage::disc,
          .parameters = {{.name = "amplitude",
                          .meaning = "final size",
                          .fallback = 0.0,
                          .least = -largest_error,
                          .most = largest_error,
                          .coordinate = true},
                         {.name = "time_constant",
                          .dimension = dimension::time,
                          .meaning = "of the exponential approach; without it: an offset",
                          .least = 0,
                          .open_below = true},
                         {.name = "coefficient",
                          .dimension = dimension::angle_per_temperature,
                          .meaning = "change per kelvin, with a temperature column",
                          .fallback = 0.0}},
          .action = action,
          .share = share,
          .need = Need::temperature,
          .terms = terms,
          .record = "a return to the start, and the temperature",
          .missing_signal = missing_signal,
          .remedy = {true, "let the robot warm up before use, or compensate with a temperature sensor"}};
}

}  // namespace qerr
