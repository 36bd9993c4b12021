#include "effect/effects/effects.hpp"
#include "encoder/loop_reading.hpp"

namespace qerr {

namespace {

/// x(t - delay) - x(t) = -delay v + delay^2/2 a, linearized about a delay.
Term linearized(const RecordSignals& s, const Term& t, const Eigen::VectorXd& delay) {
  Term next = t;
  next.columns = -s.joint_rate() + delay[0] * s.acceleration;
  next.fixed = -0.5 * delay[0] * delay[0] * s.acceleration;
  return next;
}

std::vector<Term> terms(const RecordSignals& s) {
  if (!s.ordered || s.is_stationary()) return {};
  Term t = linear_term(s, "latency", -s.joint_rate(),
                       [](Effect& e, const Eigen::VectorXd& c) { e.numbers["delay"] = c[0]; });
  if (s.acceleration.size() > 0) t.relinearized = linearized;
  return {t};
}

}  // namespace

EffectKind latency_effect() {
  return {.name = "latency",
          .summary = "delay between sampling and time stamp of a reading",
          .typical = "fractions of a sample to 34 ms over a field bus",
          .stage = Stage::clock,
          .parameters = {{.name = "delay",
                          .dimension = dimension::time,
                          .meaning = "age of the reading",
                          .required = true,
                          .least = -longest_delay,
                          .most = longest_delay,
                          .usual = 1}},
          .action = [](const Effect& e, const Encoder&, std::uint64_t) -> Action {
            return [delay = e.number("delay")](double t, const Moment&) { return t - delay; };
          },
          .share = [](const Effect& e, const Encoder&,
                      const Usage& u) { return proportional(-e.number("delay"), u.velocity); },
          .need = Need::velocity,
          .in_loop = [](const Effect& e, const Encoder&, LoopReading& r) { r.delay += e.number("delay"); },
          .terms = terms,
          .twins = {{"backlash", "reversals at two speeds or more, with a standstill after each"},
                    {"clock_drift", "a longer record, with the same speeds at its start and at its end"}},
          .remedy = {true, "add delay times velocity to the reading, or stamp it when it is taken"}};
}

}  // namespace qerr
