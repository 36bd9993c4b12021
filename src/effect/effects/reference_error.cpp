#include <cmath>

#include "effect/effects/effects.hpp"
#include "effect/effects/periodic.hpp"

namespace qerr {

namespace {

/// A sine that the reference sensor adds to the joint's angle. Its argument is the true angle, where the
/// reference would be without the error.
Term linearized(const RecordSignals& s, const Term& old, const Eigen::VectorXd& c) {
  constexpr int iterations = 8;  // of a fixed point with the contraction amplitude * order < 1
  const double n = old.effect.number("order");
  Eigen::ArrayXd angle = s.joint_angle();
  for (int i = 0; i < iterations; ++i)
    angle = s.joint_angle() - c[0] * (n * angle).sin() - c[1] * (n * angle).cos();
  Term next = old;
  next.columns.resize(s.rows(), 2);
  next.columns << -(n * angle).sin(), -(n * angle).cos();
  return next;
}

/// Steppers, the usual references, have errors at multiples of their teeth.
std::vector<Term> terms(const RecordSignals& s) {
  std::vector<Term> all;
  if (s.prismatic || s.is_stationary()) return all;
  for (const double order : {50.0, 100.0, 200.0}) {
    Term t;
    t.effect = {"reference_error", s.joint, {{"order", order}}, {}};
    t.fill = fill_periodic;
    t.relinearized = linearized;
    all.push_back(linearized(s, t, Eigen::Vector2d::Zero()));
  }
  return all;
}

}  // namespace

EffectKind reference_error_effect() {
  return {
      .name = "reference_error",
      .summary = "periodic error of the reference sensor, `order` periods per joint revolution",
      .typical = "steppers used as reference: 0.003 to 0.14 deg at orders 50 and 100",
      .stage = Stage::reference,
      .parameters = {periodic_amplitude(),
                     periodic_phase(),
                     {.name = "order",
                      .meaning = "periods per joint revolution",
                      .required = true,
                      .least = 0,
                      .open_below = true}},
      .action = [](const Effect& e, const Encoder&, std::uint64_t) -> Action {
        return [amplitude = e.number("amplitude"), phase = e.number("phase"), order = e.number("order")](
                   double x, const Moment&) { return x + amplitude * std::sin(order * x + phase); };
      },
      .share = [](const Effect&, const Encoder&, const Usage&) -> std::optional<Share> { return Share{}; },
      .terms = terms,
      .twins = {{"transmission_error", {}, [](const Effect&, const RecordSignals&) { return true; }}},
      .remedy = {false, "nothing to compensate in the robot: the error belongs to the reference sensor"}};
}

}  // namespace qerr
