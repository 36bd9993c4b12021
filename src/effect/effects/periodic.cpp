#include "periodic.hpp"

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

Action periodic_action(const Effect& e, const Encoder& encoder, std::uint64_t) {
  const auto shaft = e.choices.find("shaft");
  const bool of_joint = shaft != e.choices.end() && shaft->second == "joint";
  const double order = e.number("order") * (of_joint ? 1 : encoder.shaft_ratio);
  return [=, amplitude = e.number("amplitude"), phase = e.number("phase")](double x, const Moment& m) {
    return x + amplitude * std::sin(order * (of_joint ? m.joint : x) + phase);
  };
}

Share periodic_share(const Effect& e, const Encoder&, const Usage&) {
  const double amplitude = e.number("amplitude");
  return {0, amplitude, amplitude / std::numbers::sqrt2};
}

}  // namespace qerr
