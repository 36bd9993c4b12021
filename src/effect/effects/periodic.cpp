#include "effect/effects/periodic.hpp"

#include <cmath>
#include <numbers>

namespace qerr {

Parameter periodic_amplitude() {
  return {.name = "amplitude",
          .meaning = "peak of the error at the joint",
          .required = true,
          .least = 0,
          .coordinate = true};
}

Parameter periodic_phase() {
  return {.name = "phase",
          .dimension = dimension::angle,
          .meaning = "phase of the sine at angle zero",
          .fallback = 0.0};
}

Parameter periodic_shaft() {
  return {.name = "shaft",
          .kind = Kind::choice,
          .meaning = "the shaft whose angle the order counts",
          .choices = "encoder|joint"};
}

namespace {

bool counts_joint_turns(const Effect& e) {
  const auto shaft = e.choices.find("shaft");
  return shaft != e.choices.end() && shaft->second == "joint";
}

}  // namespace

double wave_number(const Effect& e, const Encoder& encoder) {
  return e.number_or("order", 0) * (counts_joint_turns(e) ? 1 : encoder.shaft_ratio);
}

Action periodic_action(const Effect& e, const Encoder& encoder, std::uint64_t) {
  const bool of_joint = counts_joint_turns(e);
  const double order = wave_number(e, encoder);
  return [=, amplitude = e.number("amplitude"), phase = e.number("phase")](double x, const Moment& m) {
    return x + amplitude * std::sin(order * (of_joint ? m.joint : x) + phase);
  };
}

std::optional<Share> periodic_share(const Effect& e, const Encoder& encoder, const Usage&) {
  const double amplitude = e.number("amplitude");
  return Share{0, amplitude, amplitude / std::numbers::sqrt2, Course::travel, {{wave_number(e, encoder), 1}}};
}

}  // namespace qerr
