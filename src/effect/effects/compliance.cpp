#include "effect/effects/effects.hpp"

namespace qerr {

namespace {

std::vector<Term> terms(const RecordSignals& s) {
  if (s.effort.size() == 0) return {};
  return {linear_term(s, "compliance", s.effort,
                      [](Effect& e, const Eigen::VectorXd& c) { e.numbers["compliance"] = c[0]; })};
}

std::optional<MissingSignal> missing_signal(const RecordSignals& s) {
  if (s.effort.size() > 0) return std::nullopt;
  return MissingSignal{"compliance",
                       "the column " + s.joint + ".effort; the URDF has no masses to plan it with"};
}

constexpr std::string_view payload = "the same motion with another payload, and faster";

}  // namespace

EffectKind compliance_effect() {
  return {.name = "compliance",
          .summary = "wind-up of gear and link under load",
          .typical = "0.1 to 3 mrad at rated load",
          .stage = Stage::link,
          .parameters = {{.name = "compliance",
                          .dimension = dimension::compliance,
                          .meaning = "angle per torque",
                          .required = true,
                          .least = 0}},
          .action = [](const Effect& e, const Encoder&, std::uint64_t) -> Action {
            return [c = e.number("compliance")](double x, const Moment& m) { return x + c * m.effort; };
          },
          .share = [](const Effect& e, const Encoder&,
                      const Usage& u) { return proportional(e.number("compliance"), u.effort); },
          .need = Need::effort,
          .terms = terms,
          .twins = {{"drift", payload}},
          .record = payload,
          .missing_signal = missing_signal,
          .remedy = {true, "subtract compliance times the model's load from the reading"}};
}

}  // namespace qerr
