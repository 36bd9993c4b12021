#include <algorithm>

#include "effect/effects/effects.hpp"

namespace qerr {

namespace {

/// Direction of dry friction by the speed, without a jump at rest: -1 to 1.
Eigen::ArrayXd side_of_friction(const Eigen::ArrayXd& velocity) {
  constexpr double slow = 0.02;  // of the highest speed: there the direction is uncertain (convention)
  return (velocity / (slow * std::max(velocity.abs().maxCoeff(), 1e-300))).max(-1.0).min(1.0);
}

/// The part of an effort that a drive needs for itself, and that its gear does not transmit.
template <typename Number>
Number needed(const Effect& e, const Number& side, const Number& velocity, const Number& acceleration) {
  return e.number_or("friction", 0) * side + e.number_or("damping", 0) * velocity +
         e.number_or("inertia", 0) * acceleration;
}

/// C (effort - friction side - inertia acceleration - damping velocity), linear in C and its products.
void fill_of_drive(Effect& e, const Eigen::VectorXd& c) {
  e.numbers["compliance"] = c[0];
  e.numbers["friction"] = std::max(0.0, c[1] / c[0]);
  if (c.size() == 2) return;
  e.numbers["inertia"] = std::max(0.0, c[2] / c[0]);
  e.numbers["damping"] = c[3] / c[0];
}

/// By the effort as a load, and as the torque of a drive: also without its inertia, which is not told from
/// the load's where nothing but inertia loads the joint. Friction that falls with the speed has a negative
/// damping.
std::vector<Term> terms(const RecordSignals& s) {
  if (s.effort.size() == 0) return {};
  Term load = linear_term(s, "compliance", s.effort,
                          [](Effect& e, const Eigen::VectorXd& c) { e.numbers["compliance"] = c[0]; });
  if (!s.driven || !s.ordered || s.measured.size() == 0 || s.acceleration.size() == 0 || s.is_stationary())
    return {load};
  Term drive = load;
  drive.columns.resize(s.rows(), 4);
  drive.columns << s.effort, -side_of_friction(s.joint_rate()), -s.acceleration, -s.joint_rate();
  drive.fill = fill_of_drive;
  drive.positive = 3;
  Term slow = drive;
  slow.columns = drive.columns.leftCols(2).eval();
  slow.positive = 2;
  return {load, slow, drive};
}

/// The side of friction as the terms have it.
Eigen::ArrayXd replay(const Effect& e, const RecordSignals& s) {
  if (s.effort.size() == 0) return {};
  const bool known = s.acceleration.size() > 0 && s.ordered;
  if (!known) return e.number("compliance") * s.effort;
  return e.number("compliance") * (s.effort - needed<Eigen::ArrayXd>(e, side_of_friction(s.joint_rate()),
                                                                     s.joint_rate(), s.acceleration));
}

std::optional<MissingSignal> missing_signal(const RecordSignals& s) {
  if (s.effort.size() > 0) return std::nullopt;
  return MissingSignal{"compliance",
                       "the column " + s.joint + ".effort; the URDF has no masses to plan it with"};
}

constexpr std::string_view payload = "the same motion with another payload, and faster";

}  // namespace

EffectKind compliance_effect() {
  return {
      .name = "compliance",
      .summary = "wind-up of gear and link under load",
      .typical = "0.1 to 3 mrad at rated load",
      .stage = Stage::link,
      .parameters = {{.name = "compliance",
                      .dimension = dimension::compliance,
                      .meaning = "angle per torque",
                      .required = true,
                      .least = 0},
                     {.name = "friction",
                      .dimension = dimension::torque,
                      .meaning = "dry friction in the effort that the gear does not transmit",
                      .fallback = 0.0,
                      .least = 0},
                     {.name = "inertia",
                      .dimension = dimension::inertia,
                      .meaning = "the drive's, which the effort accelerates beside the load",
                      .fallback = 0.0,
                      .least = 0},
                     {.name = "damping",
                      .dimension = dimension::damping,
                      .meaning = "viscous friction in the effort; negative if friction falls with the speed",
                      .fallback = 0.0}},
      .action = [](const Effect& e, const Encoder&, std::uint64_t) -> Action {
        return [e](double x, const Moment& m) {
          constexpr double rest =
              0.01;  // [rad/s or m/s], below which friction's side is uncertain (convention)
          const double side = std::clamp(m.velocity / rest, -1.0, 1.0);
          return x +
                 e.number("compliance") * (m.effort - needed<double>(e, side, m.velocity, m.acceleration));
        };
      },
      .share = [](const Effect& e, const Encoder&,
                  const Usage& u) { return proportional(e.number("compliance"), u.effort); },
      .need = Need::effort,
      .terms = terms,
      .replay = replay,
      .twins = {{"drift", payload}},
      .record = payload,
      .missing_signal = missing_signal,
      .remedy = {true, "subtract compliance times the model's load from the reading"}};
}

}  // namespace qerr
