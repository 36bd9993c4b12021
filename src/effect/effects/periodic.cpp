#include "effect/effects/periodic.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "effect/effects/effects.hpp"

namespace qerr {

Parameter periodic_amplitude() {
  return {.name = "amplitude",
          .meaning = "peak of the error at the joint",
          .required = true,
          .least = 0,
          .most = largest_error,
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

bool refers_to_joint(const Effect& e) {
  const auto shaft = e.choices.find("shaft");
  return shaft != e.choices.end() && shaft->second == "joint";
}

double wave_number(const Effect& e, const Encoder& encoder) {
  return e.number_or("order", 0) * (refers_to_joint(e) ? 1 : encoder.shaft_ratio);
}

Action periodic_action(const Effect& e, const Encoder& encoder, std::uint64_t) {
  const bool of_joint = refers_to_joint(e);
  const double order = wave_number(e, encoder);
  return [=, amplitude = e.number("amplitude"), phase = e.number("phase")](double x, const Moment& m) {
    return x + amplitude * std::sin(order * (of_joint ? m.joint : x) + phase);
  };
}

bool is_periodic(const EffectKind& kind) { return kind.action == periodic_action; }

std::optional<Share> periodic_share(const Effect& e, const Encoder&, const Usage&) {
  const double amplitude = e.number("amplitude");
  return Share{0, amplitude, amplitude / std::numbers::sqrt2, Spectrum::motion};
}

void fill_periodic(Effect& e, const Eigen::VectorXd& c) {
  // amplitude sin(angle + phase) = c0 sin(angle) + c1 cos(angle).
  e.numbers["amplitude"] = std::hypot(c[0], c[1]);
  e.numbers["phase"] = std::atan2(c[1], c[0]);
}

namespace {

Term along(const RecordSignals& s, const Term& t, const Eigen::ArrayXd& moved) {
  // A disc rotates with the encoder's coordinate, a gear with the joint.
  const bool of_disc = effect_kind(t.effect.type).stage == Stage::disc;
  Eigen::ArrayXd angle = of_disc ? s.path : s.joint_angle();
  if (moved.size() > 0) angle += moved;
  angle *= wave_number(t.effect, s.encoder);
  Term next = t;
  next.moved = moved;
  next.columns.resize(s.rows(), 2);
  for (Eigen::Index k = 0; k < s.rows(); ++k) {
    const double at = angle[k], sine = std::sin(at), cosine = std::cos(at);  // one call for both
    next.columns.row(k) << sine, cosine;
  }
  return next;
}

Term harmonic(const RecordSignals& s, const char* effect, double order, bool of_encoder) {
  Term t;
  t.effect = {effect, s.joint, {{"order", order}}, {{"shaft", of_encoder ? "encoder" : "joint"}}};
  t.fill = fill_periodic;
  t.harmonic = true;
  t.along = along;
  return along(s, t, {});
}

}  // namespace

Term periodic_term(const RecordSignals& s, double order, bool of_encoder) {
  return harmonic(s, order == 1 ? "eccentricity" : "transmission_error", order, of_encoder);
}

Term free_order_term(const RecordSignals& s, double order) {
  Term t = harmonic(s, "transmission_error", order, false);
  t.unnamed = "periodic in the position";
  t.shape = order;
  t.half_width =
      std::numbers::pi / std::max(1e-12, s.joint_angle().maxCoeff() - s.joint_angle().minCoeff()) / 2;
  t.reshaped = [](const RecordSignals& record, const Term&, double shape) {
    return free_order_term(record, shape);
  };
  return t;
}

std::vector<Term> periodic_terms(const RecordSignals& s, std::initializer_list<double> encoder_orders,
                                 std::initializer_list<double> joint_orders) {
  std::vector<Term> terms;
  if (s.is_stationary()) return terms;
  const auto add = [&](std::initializer_list<double> orders, bool of_encoder) {
    constexpr double least = 0.1;  // of a period: of less, a line leaves 2 % (rms)
    for (const double order : orders) {
      Term t = periodic_term(s, order, of_encoder);
      if (periods_covered(t.effect, s) > least) terms.push_back(std::move(t));
    }
  };
  add(encoder_orders, true);
  if (std::abs(std::abs(s.encoder.shaft_ratio) - 1) > 1e-9 && !s.prismatic) add(joint_orders, false);
  return terms;
}

double periods_covered(const Effect& e, const RecordSignals& s) {
  return std::abs(wave_number(e, s.encoder)) * s.range() / (2 * std::numbers::pi);
}

bool has_one_period(const Encoder& encoder) {
  const double period = encoder.counts_per_period * encoder.resolution * std::abs(encoder.shaft_ratio);
  return encoder.counts_per_period > 4 && std::abs(period / (2 * std::numbers::pi) - 1) < 1e-6;
}

std::vector<Twin> periodic_twins() {
  return {{"reference_error",
           "the same motion with a second reference, or with the reference rotated on its shaft",
           // Steppers, the usual references, have errors of 50 and 100 periods per revolution. Behind a gear
           // the reference is what turns with the joint's shaft.
           [](const Effect& e, const RecordSignals& s) {
             const double order = std::abs(wave_number(e, s.encoder));
             return refers_to_joint(e) || (std::abs(std::remainder(order, 50)) < 1e-3 && order > 1);
           }},
          {"compliance",
           {},
           // The torque of an unmeasured weight is a cosine of the angle. A motor's has friction, too, and
           // does not tell all of it.
           [](const Effect& e, const RecordSignals& s) {
             return std::abs(std::abs(wave_number(e, s.encoder)) - 1) < 1e-6 && s.loaded &&
                    (s.effort.size() == 0 || refers_to_joint(e));
           }},
          {"subdivision_error", {}, [](const Effect&, const RecordSignals& s) {
             return has_one_period(s.encoder);
           }}};
}

TableShape periodic_table() {
  return {.period = [](const Effect& e, const Encoder& encoder) {
    const double number = std::abs(wave_number(e, encoder));
    return number > 0 ? 2 * std::numbers::pi / number : 0;
  }};
}

}  // namespace qerr
