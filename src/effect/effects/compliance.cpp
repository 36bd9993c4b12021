#include <algorithm>
#include <cmath>

#include "core/solve.hpp"
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

/// Whether the load is the link's own, by its motion, and not the effort.
bool has_own_load(const Effect& e) {
  return e.number_or("load_inertia", 0) != 0 || e.number_or("load_moment", 0) != 0;
}

/// What the link's inertia and weight need. @param angle  of the joint from its zero
template <typename Number>
Number own_load(const Effect& e, const Number& angle, const Number& acceleration) {
  using std::cos;
  return e.number_or("load_inertia", 0) * acceleration +
         e.number_or("load_moment", 0) * cos(angle - e.number_or("load_angle", 0));
}

/// C J acceleration, with the J that the effort says.
void fill_of_inertia(Effect& e, const Eigen::VectorXd& c) {
  e.numbers["compliance"] = c[0] / e.number("load_inertia");
}

/// C (J acceleration + M cos(angle - phase)).
void fill_of_link(Effect& e, const Eigen::VectorXd& c) {
  fill_of_inertia(e, c);
  e.numbers["load_moment"] = std::hypot(c[1], c[2]) / std::max(e.number("compliance"), 1e-300);
  e.numbers["load_angle"] = std::atan2(c[2], c[1]);
}

/// What the link's inertia winds up, and its weight.
Eigen::ArrayXXd link_columns(const RecordSignals& s, Eigen::Index count) {
  const Eigen::ArrayXd& angle = s.joint_angle();
  Eigen::ArrayXXd link(s.rows(), 3);
  link << s.acceleration, angle.cos(), angle.sin();
  return link.leftCols(count);
}

/// The term with the inertia that the effort says: this is the load and friction, so that its slope on the
/// wind-up is 1/C. Of a drive that carries its own inertia, too, C is at least what is found.
/// @param c  coefficients of the term, whose columns wind the gear up
Term calibrated(const RecordSignals& s, const Term& t, const Eigen::VectorXd& c) {
  Term said = t;
  said.columns = link_columns(s, t.size());
  Eigen::MatrixXd parts(s.rows(), 4);
  parts << Eigen::VectorXd::Ones(s.rows()), said.columns.matrix() * c,
      side_of_friction(s.joint_rate()).matrix(), s.joint_rate().matrix();
  const double stiffness = least_norm_solution(parts, s.effort.matrix())(1, 0);
  if (stiffness * c[0] > 0) said.effect.numbers["load_inertia"] = stiffness * c[0];
  return said;
}

/// The errors' slope on a signal beside others, over its uncertainty, and the rms that all leave.
struct Slope {
  double value, significance, left;

  Slope(const RecordSignals& s, const Eigen::ArrayXd& signal, const Eigen::MatrixXd& others) {
    Eigen::MatrixXd both(s.rows(), 2);
    both << signal.matrix(), (s.measured - s.path).matrix();
    both -= others * least_norm_solution(others, both);
    const double norm = std::max(both.col(0).norm(), 1e-150);
    value = both.col(0).dot(both.col(1)) / (norm * norm);
    left = (both.col(1) - value * both.col(0)).norm() / std::sqrt(static_cast<double>(s.rows()));
    significance = value * norm / std::max(left, 1e-150);
  }
};

constexpr double significant = 6;  // sigma, as rows are correlated

/// Whether the errors follow the acceleration, beside what follows the position or the speed, and leave
/// little more than rounding: only then is an own load told from errors of a shaft's angle, and from a
/// reference whose noise is smoothed. Not if the drive's torque says as much: it knows the compliance.
bool follows_acceleration(const RecordSignals& s) {
  constexpr double noticeable = 0.2, quantized = 0.4;  // counts, of which rounding leaves 0.29 (conventions)
  constexpr double as_much = 1.02;                     // of what is left
  const Eigen::ArrayXd &angle = s.joint_angle(), &a = s.acceleration;
  const Eigen::ArrayXd side = side_of_friction(s.joint_rate());
  Eigen::MatrixXd beside(s.rows(), 8), of_drive(s.rows(), 5);
  beside << Eigen::VectorXd::Ones(s.rows()), angle.matrix(), angle.cos().matrix(), angle.sin().matrix(),
      (2 * angle).cos().matrix(), (2 * angle).sin().matrix(), s.joint_rate().matrix(), side.matrix();
  of_drive << Eigen::VectorXd::Ones(s.rows()), angle.matrix(), side.matrix(), a.matrix(),
      s.joint_rate().matrix();
  const Slope inertia(s, a, beside), drive(s, s.effort, of_drive);
  return inertia.left < quantized * s.step() && inertia.significance > significant &&
         inertia.value * std::sqrt((a - a.mean()).square().mean()) > noticeable * s.step() &&
         !(drive.significance > significant && drive.left < as_much * inertia.left);
}

/// By the link's inertia and weight, where a drive's friction hides the load in its effort. None if the
/// effort has nothing of it.
std::optional<Term> by_own_load(const RecordSignals& s, Eigen::Index count,
                                void (*fill)(Effect&, const Eigen::VectorXd&)) {
  Term t = linear_term(s, "compliance", s.acceleration, fill);
  t.columns = link_columns(s, count);
  t.positive = 1;
  Eigen::MatrixXd fit(s.rows(), count + 1);
  fit << Eigen::VectorXd::Ones(s.rows()), t.columns.matrix();
  const Eigen::VectorXd c = least_norm_solution(fit, (s.measured - s.path).matrix()).bottomRows(count);
  t = calibrated(s, t, c);
  if (!(c[0] > 0) || t.effect.numbers.empty()) return std::nullopt;
  t.relinearized = calibrated;
  return t;
}

/// By the effort as a load, and as the torque of a drive: also without its inertia, which is not told from
/// the load's where nothing but inertia loads the joint. Friction that falls with the speed has a negative
/// damping. And by the link's own load, where the errors follow the acceleration.
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
  std::vector<Term> all{load, slow, drive};
  if (!follows_acceleration(s)) return all;
  if (auto t = by_own_load(s, 1, fill_of_inertia)) all.push_back(std::move(*t));
  if (!s.prismatic)
    if (auto t = by_own_load(s, 3, fill_of_link)) all.push_back(std::move(*t));
  return all;
}

/// The side of friction as the terms have it.
Eigen::ArrayXd replay(const Effect& e, const RecordSignals& s) {
  const bool known = s.acceleration.size() > 0 && s.ordered;
  if (has_own_load(e)) {
    if (!known) return {};
    return e.number("compliance") * own_load<Eigen::ArrayXd>(e, s.joint_angle(), s.acceleration);
  }
  if (s.effort.size() == 0) return {};
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
                      .fallback = 0.0},
                     {.name = "load_inertia",
                      .dimension = dimension::inertia,
                      .meaning = "the link's, which loads the gear in place of the effort; as found it "
                                 "holds the drive's, too: the compliance is at least that found",
                      .fallback = 0.0,
                      .least = 0},
                     {.name = "load_moment",
                      .dimension = dimension::torque,
                      .meaning = "the link's weight at its largest lever, in place of the effort",
                      .fallback = 0.0,
                      .least = 0},
                     {.name = "load_angle",
                      .dimension = dimension::angle,
                      .meaning = "joint angle of that lever",
                      .fallback = 0.0}},
      .action = [](const Effect& e, const Encoder&, std::uint64_t) -> Action {
        if (has_own_load(e))
          return [e](double x, const Moment& m) {
            return x + e.number("compliance") * own_load<double>(e, m.joint, m.acceleration);
          };
        return [e](double x, const Moment& m) {
          constexpr double rest =
              0.01;  // [rad/s or m/s], below which friction's side is uncertain (convention)
          const double side = std::clamp(m.velocity / rest, -1.0, 1.0);
          return x +
                 e.number("compliance") * (m.effort - needed<double>(e, side, m.velocity, m.acceleration));
        };
      },
      // A usage has no acceleration: an own load is known along a motion only.
      .share = [](const Effect& e, const Encoder&, const Usage& u) -> std::optional<Share> {
        if (has_own_load(e)) return std::nullopt;
        return proportional(e.number("compliance"), u.effort);
      },
      .need = Need::effort,
      .terms = terms,
      .replay = replay,
      .twins = {{"drift", payload}},
      .record = payload,
      .missing_signal = missing_signal,
      .remedy = {true, "subtract compliance times the model's load from the reading"}};
}

}  // namespace qerr
