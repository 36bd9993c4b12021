#include "effect/effects/effects.hpp"

namespace qerr {

namespace {

std::vector<Term> displacements(const std::string& joint) {
  std::vector<Term> terms;
  for (const char* axis : {"x", "y", "z"}) {
    Term t;
    t.effect = {"geometry", joint, {}, {{"axis", axis}}};
    t.fill = [](Effect& e, const Eigen::VectorXd& c) { e.numbers["length"] = c[0]; };
    terms.push_back(std::move(t));
  }
  return terms;
}

}  // namespace

EffectKind geometry_effect() {
  return {.name = "geometry",
          .summary = "link dimension differs from the URDF",
          .typical = "0.1 to 1 mm before calibration",
          .stage = Stage::kinematics,
          .parameters = {{.name = "axis",
                          .kind = Kind::choice,
                          .meaning = "direction in the frame before the joint",
                          .choices = "x|y|z"},
                         {.name = "length",
                          .dimension = dimension::length,
                          .meaning = "displacement of the joint's origin",
                          .required = true,
                          .least = -largest_error,
                          .most = largest_error,
                          .usual = 0.1}},
          // The true joint is displaced from the model's: estimate - true is minus the displacement.
          .share = [](const Effect& e, const Encoder&, const Usage&) -> std::optional<Share> {
            return Share{0.0 - e.number("length"), 0, 0};
          },
          .displacements = displacements,
          .remedy = {false, "correct the link in the URDF"}};
}

}  // namespace qerr
