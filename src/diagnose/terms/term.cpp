#include "diagnose/terms/term.hpp"

#include <cmath>
#include <initializer_list>
#include <numbers>

#include "diagnose/terms/subdivision.hpp"

namespace qerr {

namespace {

void fill_periodic(Effect& e, const Eigen::VectorXd& c) {
  // amplitude sin(angle + phase) = c0 sin(angle) + c1 cos(angle).
  e.numbers["amplitude"] = std::hypot(c[0], c[1]);
  e.numbers["phase"] = std::atan2(c[1], c[0]);
}

Term linear(const Evidence& e, const char* type, const Eigen::ArrayXd& column,
            void (*fill)(Effect&, const Eigen::VectorXd&)) {
  Term t;
  t.effect = {type, e.joint, {}, {}};
  t.columns = column;
  t.fill = fill;
  return t;
}

Term drift_term(const Evidence& e, double time_constant) {
  Term t = linear(e, "drift", 1 - (-e.time / time_constant).exp(),
                  [](Effect& x, const Eigen::VectorXd& c) { x.numbers["amplitude"] = c[0]; });
  t.effect.numbers["time_constant"] = t.shape = time_constant;
  t.reach = 0.7 * time_constant;
  t.reshaped = [](const Evidence& record, const Term&, double shape) { return drift_term(record, shape); };
  return t;
}

/// A sine that the better sensor adds to the angle it tells. Its argument is the true angle, which is where
/// the reference would be without it: an error of the joint's own machine goes with the reference as it is.
Term reference_error_term(const Evidence& e, double order) {
  Term t;
  t.effect = {"reference_error", e.joint, {{"order", order}}, {}};
  t.fill = fill_periodic;
  t.relinearized = [](const Evidence& record, const Term& old, const Eigen::VectorXd& c) {
    constexpr int turns = 8;  // of a fixed point that the slope amplitude * order < 1 draws near
    const double n = old.effect.number("order");
    Eigen::ArrayXd angle = record.joint_angle();
    for (int i = 0; i < turns; ++i)
      angle = record.joint_angle() - c[0] * (n * angle).sin() - c[1] * (n * angle).cos();
    Term next = old;
    next.columns.resize(record.rows(), 2);
    next.columns << -(n * angle).sin(), -(n * angle).cos();
    return next;
  };
  return t.relinearized(e, t, Eigen::Vector2d::Zero());
}

/// Piecewise linear functions of an argument, each 1 in its own knot. The first is left out: it is the
/// constant.
Eigen::ArrayXXd hats(const Eigen::ArrayXd& argument, Eigen::Index knots) {
  const double low = argument.minCoeff(),
               spacing = (argument.maxCoeff() - low) / static_cast<double>(knots - 1);
  Eigen::ArrayXXd columns(argument.size(), knots - 1);
  for (Eigen::Index i = 1; i < knots; ++i)
    columns.col(i - 1) = (1 - ((argument - low) / spacing - static_cast<double>(i)).abs()).max(0.0);
  return columns;
}

Term periodic_along(const Evidence& e, const Term& t, const Eigen::ArrayXd& moved) {
  // A disc turns with what its encoder feels, a gear with its joint.
  const bool disc = t.effect.type == "eccentricity";
  Eigen::ArrayXd angle = disc ? e.path : e.joint_angle();
  if (moved.size() > 0) angle += moved;
  angle *= wave_number(t.effect, e.encoder);
  Term next = t;
  next.moved = moved;
  next.columns.resize(e.rows(), 2);
  next.columns << angle.sin(), angle.cos();
  return next;
}

void no_parameters(Effect&, const Eigen::VectorXd&) {}

Term without_name(const Evidence& e, std::string what, Eigen::ArrayXXd columns) {
  Term t;
  t.effect = {"", e.joint, {}, {}};
  t.columns = std::move(columns);
  t.fill = no_parameters;
  t.unnamed = std::move(what);
  return t;
}

void add_drifts(const Evidence& e, std::vector<Term>& terms) {
  const double duration = e.time[e.rows() - 1];
  for (const double part : {0.1, 0.3, 1.0}) terms.push_back(drift_term(e, part * duration));
  if (e.temperature.size() > 0)
    terms.push_back(linear(e, "drift", e.temperature,
                           [](Effect& x, const Eigen::VectorXd& c) { x.numbers["coefficient"] = c[0]; }));
}

}  // namespace

Eigen::ArrayXd addition(const Term& t, const Eigen::VectorXd& coefficients) {
  Eigen::ArrayXd added = (t.columns.matrix() * coefficients).array();
  if (t.fixed.size() > 0) added += t.fixed;
  return added;
}

Term with_columns(Term t, Eigen::ArrayXXd columns) {
  t.columns = std::move(columns);
  t.fixed.resize(0);
  t.reshaped = nullptr;
  t.relinearized = nullptr;
  t.along = nullptr;
  return t;
}

Term periodic_term(const Evidence& e, const char* type, double order, bool of_encoder) {
  Term t;
  t.effect = {type, e.joint, {{"order", order}}, {{"shaft", of_encoder ? "encoder" : "joint"}}};
  t.fill = fill_periodic;
  t.along = periodic_along;
  return periodic_along(e, t, {});
}

Term free_order_term(const Evidence& e, double order) {
  Term t = periodic_term(e, "transmission_error", order, false);
  t.unnamed = "periodic in the position";
  t.shape = order;
  t.reach = std::numbers::pi / std::max(1e-12, e.joint_angle().maxCoeff() - e.joint_angle().minCoeff()) / 2;
  t.reshaped = [](const Evidence& record, const Term&, double shape) {
    return free_order_term(record, shape);
  };
  return t;
}

Term position_table_term(const Evidence& e, Eigen::Index knots) {
  return without_name(e, "repeats with the position, and has no period", hats(e.path, knots));
}

Term time_table_term(const Evidence& e, Eigen::Index knots) {
  return without_name(e, "slow in time", hats(e.time, knots));
}

Term vibration_term(const Evidence& e, double frequency) {
  const Eigen::ArrayXd angle = 2 * std::numbers::pi * frequency * e.time;
  Eigen::ArrayXXd columns(e.rows(), 2);
  columns << angle.sin(), angle.cos();
  Term t = without_name(e, "vibrates", std::move(columns));
  t.effect.numbers["frequency"] = t.shape = frequency;
  t.fill = fill_periodic;
  t.reach = 0.25 / std::max(1e-9, e.time[e.rows() - 1]);
  t.reshaped = [](const Evidence& record, const Term&, double shape) {
    return vibration_term(record, shape);
  };
  return t;
}

Term step_term(const Evidence& e, double time) {
  Term t = linear(e, "missed_counts", (e.time >= time).cast<double>() * e.step(),
                  [](Effect& x, const Eigen::VectorXd& c) { x.numbers["counts"] = c[0]; });
  t.effect.numbers["time"] = time;
  return t;
}

namespace {

/// Orders of a shaft of which the record has seen more than a bend.
void add_periodic(const Evidence& e, bool of_encoder, std::initializer_list<double> orders,
                  std::vector<Term>& terms) {
  constexpr double least = 0.1;  // of a period
  const double range = e.path.maxCoeff() - e.path.minCoeff();
  for (const double order : orders)
    if (order * (of_encoder ? std::abs(e.encoder.shaft_ratio) : 1) * range > least * 2 * std::numbers::pi)
      terms.push_back(
          periodic_term(e, order == 1 ? "eccentricity" : "transmission_error", order, of_encoder));
}

}  // namespace

std::vector<Term> named_terms(const Evidence& e) {
  std::vector<Term> terms;
  const bool geared = std::abs(std::abs(e.encoder.shaft_ratio) - 1) > 1e-9;
  if (e.encoder.zero_known)
    terms.push_back(linear(e, "offset", Eigen::ArrayXd::Ones(e.rows()),
                           [](Effect& x, const Eigen::VectorXd& c) { x.numbers["offset"] = c[0]; }));
  if (!e.is_stationary()) {
    terms.push_back(
        linear(e, "scale", e.path, [](Effect& x, const Eigen::VectorXd& c) { x.numbers["scale"] = c[0]; }));
    add_periodic(e, true, {1, 2, 3, 4, 6, 8}, terms);
    if (geared && !e.prismatic) add_periodic(e, false, {1, 2, 3, 4}, terms);
    if (e.encoder.counts_per_period > 4)
      for (Term& t : subdivision_terms(e)) terms.push_back(std::move(t));
  }
  if (e.effort.size() > 0)
    terms.push_back(linear(e, "compliance", e.effort,
                           [](Effect& x, const Eigen::VectorXd& c) { x.numbers["compliance"] = c[0]; }));
  // Steppers, the usual references, err at the orders of their teeth.
  if (!e.prismatic && !e.is_stationary())
    for (const double order : {50.0, 100.0, 200.0}) terms.push_back(reference_error_term(e, order));
  if (!e.ordered) return terms;
  add_drifts(e, terms);
  if (e.is_stationary()) return terms;
  terms.push_back(linear(e, "latency", -e.joint_rate(),
                         [](Effect& x, const Eigen::VectorXd& c) { x.numbers["delay"] = c[0]; }));
  terms.push_back(linear(e, "backlash", 0.5 * e.direction,
                         [](Effect& x, const Eigen::VectorXd& c) { x.numbers["gap"] = c[0]; }));
  terms.push_back(linear(e, "clock_drift", e.time * e.joint_rate(),
                         [](Effect& x, const Eigen::VectorXd& c) { x.numbers["rate"] = c[0]; }));
  return terms;
}

}  // namespace qerr
