#include "diagnose/search/unnamed_terms.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "effect/effects/effects.hpp"

namespace qerr {

namespace {

/// Piecewise linear functions of an argument, each 1 at its own knot and 0 at the others. The first is
/// omitted, as the sum of all is a constant.
Eigen::ArrayXXd hats(const Eigen::ArrayXd& argument, Eigen::Index knots) {
  const double low = argument.minCoeff(),
               spacing = (argument.maxCoeff() - low) / static_cast<double>(knots - 1);
  Eigen::ArrayXXd columns(argument.size(), knots - 1);
  for (Eigen::Index i = 1; i < knots; ++i)
    columns.col(i - 1) = (1 - ((argument - low) / spacing - static_cast<double>(i)).abs()).max(0.0);
  return columns;
}

Term unnamed_term(const RecordSignals& s, Shape pattern, std::string what, Eigen::ArrayXXd columns) {
  Term t;
  t.effect = {"", s.joint, {}, {}};
  t.columns = std::move(columns);
  t.fill = [](Effect&, const Eigen::VectorXd&) {};
  t.unnamed = std::move(what);
  t.pattern = pattern;
  return t;
}

/// Of one column whose coefficient is its size.
Term sized_term(const RecordSignals& s, Shape pattern, std::string what, Eigen::ArrayXd column) {
  Term t = unnamed_term(s, pattern, std::move(what), std::move(column));
  t.fill = [](Effect& e, const Eigen::VectorXd& c) { e.numbers["size"] = c[0]; };
  return t;
}

/// Part of a change in time that is not in proportion to it, up to which its rate is stated (convention).
constexpr double mostly_straight = 0.3;

Eigen::ArrayXd risen(const RecordSignals& s, double since, double time_constant) {
  return (s.time >= since).select(1 - (-(s.time - since).max(0.0) / time_constant).exp(), 0.0);
}

}  // namespace

Term position_table_term(const RecordSignals& s, Eigen::Index knots) {
  return unnamed_term(s, Shape::unknown, "repeats with the position, without a period", hats(s.path, knots));
}

Term time_table_term(const RecordSignals& s, Eigen::Index knots) {
  // By the time between knots: the differences of the coefficients are rates.
  const double spacing = (s.time[s.rows() - 1] - s.time[0]) / static_cast<double>(knots - 1);
  Term t = unnamed_term(s, Shape::unknown, "changes slowly in time", spacing * hats(s.time, knots));
  t.fill = [](Effect& e, const Eigen::VectorXd& c) {
    const auto n = static_cast<double>(c.size());
    const double rate = c[c.size() - 1] / n;
    if ((c - Eigen::VectorXd::LinSpaced(c.size(), rate, n * rate)).norm() < mostly_straight * c.norm())
      e.numbers["rate"] = rate;
  };
  return t;
}

namespace {

/// Legendre polynomials of degree 1 to `degree` over the range of an argument.
Eigen::ArrayXXd legendre(const Eigen::ArrayXd& argument, int degree) {
  const double low = argument.minCoeff(), half = 0.5 * (argument.maxCoeff() - low);
  const Eigen::ArrayXd u = (argument - low) / std::max(half, 1e-300) - 1;
  Eigen::ArrayXXd columns(argument.size(), degree);
  columns.col(0) = u;
  Eigen::ArrayXd before = Eigen::ArrayXd::Ones(u.size()), now = u;
  for (int n = 2; n <= degree; ++n) {
    Eigen::ArrayXd next = ((2 * n - 1) * u * now - (n - 1) * before) / n;
    before = std::exchange(now, std::move(next));
    columns.col(n - 1) = now;
  }
  return columns;
}

}  // namespace

Term position_polynomial_term(const RecordSignals& s, int degree) {
  return unnamed_term(s, Shape::unknown, "a curved function of the position", legendre(s.path, degree));
}

const char* const next_of_rate =
    "look for lost remainders of a conversion, a leak of an integrator, or clocks that differ";

Term steady_change_term(const RecordSignals& s) {
  Term t = unnamed_term(s, Shape::unknown, "changes steadily in time", s.time);
  t.fill = [](Effect& e, const Eigen::VectorXd& c) { e.numbers["rate"] = c[0]; };
  t.next = next_of_rate;
  return t;
}

Term time_polynomial_term(const RecordSignals& s, int degree) {
  // By half the duration: the coefficient of the straight line is a rate.
  const double half = 0.5 * (s.time[s.rows() - 1] - s.time[0]);
  Term t = unnamed_term(s, Shape::unknown, "changes slowly in time", half * legendre(s.time, degree));
  t.fill = [](Effect& e, const Eigen::VectorXd& c) {
    if (c.tail(c.size() - 1).norm() < mostly_straight * std::abs(c[0])) e.numbers["rate"] = c[0];
  };
  return t;
}

Term loaded_order_term(const RecordSignals& s, double order) {
  Term t = free_order_term(s, order);
  Term loaded = unnamed_term(s, Shape::order, "periodic in the position, in proportion to the load",
                             t.columns.colwise() * (s.effort / std::max(1e-300, s.effort.abs().maxCoeff())));
  loaded.effect.numbers["order"] = order;
  loaded.fill = [](Effect& e, const Eigen::VectorXd& c) { e.numbers["amplitude"] = std::hypot(c[0], c[1]); };
  return loaded;
}

Term coupling_term(const RecordSignals& s, const std::string& other, const Eigen::ArrayXd& path) {
  Term t = linear_term(s, coupling_error_effect().name, path,
                       [](Effect& e, const Eigen::VectorXd& c) { e.numbers["factor"] = c[0]; });
  t.effect.choices["of"] = other;
  return t;
}

Term vibration_term(const RecordSignals& s, double frequency) {
  const Eigen::ArrayXd angle = 2 * std::numbers::pi * frequency * s.time;
  Eigen::ArrayXXd columns(s.rows(), 2);
  columns << angle.sin(), angle.cos();
  Term t = unnamed_term(s, Shape::line, "vibrates", std::move(columns));
  t.effect.numbers["frequency"] = t.shape = frequency;
  t.fill = [](Effect& e, const Eigen::VectorXd& c) {
    // amplitude sin(angle + phase) = c0 sin(angle) + c1 cos(angle).
    e.numbers["amplitude"] = std::hypot(c[0], c[1]);
    e.numbers["phase"] = std::atan2(c[1], c[0]);
  };
  t.half_width = 0.25 / std::max(1e-9, s.time[s.rows() - 1]);
  t.reshaped = [](const RecordSignals& record, const Term&, double shape) {
    return vibration_term(record, shape);
  };
  return t;
}

Term offset_step_term(const RecordSignals& s, double time) {
  Term t = sized_term(s, Shape::step, "a step in time, not a whole number of counts",
                      (s.time >= time).cast<double>());
  t.effect.numbers["time"] = time;
  t.step = true;
  return t;
}

Term transition_term(const RecordSignals& s, double time, double time_constant) {
  Term t = sized_term(s, Shape::exponential, "an exponential approach that begins at one time",
                      risen(s, time, time_constant));
  t.effect.numbers["time"] = time;
  t.effect.numbers["time_constant"] = time_constant;
  return t;
}

Term ramp_term(const RecordSignals& s, double time, double duration) {
  Term t =
      sized_term(s, Shape::step, "a slip that takes a while", ((s.time - time) / duration).max(0.0).min(1.0));
  t.effect.numbers["time"] = time;
  t.effect.numbers["duration"] = duration;
  return t;
}

Term growth_term(const RecordSignals& s, double time_constant) {
  const Eigen::ArrayXd warm = risen(s, 0, time_constant);
  Eigen::ArrayXXd columns(s.rows(), 2);
  columns << s.path * warm, warm;
  Term t = unnamed_term(s, Shape::exponential, "grows in proportion to the position, exponentially in time",
                        std::move(columns));
  t.effect.numbers["time_constant"] = t.shape = time_constant;
  t.half_width = 0.7 * time_constant;
  t.reshaped = [](const RecordSignals& record, const Term&, double shape) {
    return growth_term(record, shape);
  };
  t.fill = [](Effect& e, const Eigen::VectorXd& c) { e.numbers["growth"] = c[0]; };
  return t;
}

Term thermal_growth_term(const RecordSignals& s) {
  Eigen::ArrayXXd columns(s.rows(), 2);
  columns << s.path * s.temperature, s.temperature;
  Term t = unnamed_term(s, Shape::exponential, "grows in proportion to the position and the temperature",
                        std::move(columns));
  t.fill = [](Effect& e, const Eigen::VectorXd& c) { e.numbers["growth_per_kelvin"] = c[0]; };
  return t;
}

Term bump_term(const RecordSignals& s, double position, double width) {
  Term t = sized_term(s, Shape::bump, "a bump at one position",
                      (-0.5 * ((s.path - position) / width).square()).exp());
  t.effect.numbers["angle"] = position;
  t.effect.numbers["width"] = width;
  return t;
}

Term speed_term(const RecordSignals& s) {
  return sized_term(s, Shape::unknown, "grows with the speed, with the same sign in both directions",
                    s.velocity.abs());
}

Term friction_term(const Sampling& sampling, const Eigen::ArrayXd& path, double travel) {
  const Evidence& e = *sampling.record;
  const double noise = std::max(6 * e.path_noise, 1e-3 * e.step());
  Eigen::ArrayXd state(e.rows()), start(e.rows());
  double at = path[0], z = 0, kept = 1;
  for (Eigen::Index k = 0; k < e.rows(); ++k) {
    const double next = std::clamp(at, path[k] - noise, path[k] + noise), by = next - at;
    if (by != 0) {
      const double side = by > 0 ? 1 : -1;
      const double forgotten = std::exp(-std::abs(by) / travel);
      z = side + (z - side) * forgotten;
      kept *= forgotten;
    }
    at = next;
    state[k] = z, start[k] = kept;
  }
  Eigen::ArrayXXd columns(static_cast<Eigen::Index>(sampling.groups.size()), 2);
  columns << sampling.averaged(state), sampling.averaged(start);
  Term t = unnamed_term(e, Shape::hysteresis, "hysteresis that builds up over a travel after each reversal",
                        std::move(columns));
  t.fill = [](Effect& effect, const Eigen::VectorXd& c) { effect.numbers["width"] = 2 * std::abs(c[0]); };
  t.effect.numbers["travel"] = travel;
  return t;
}

Term relaxation_term(const Sampling& sampling, double time_constant) {
  const Evidence& e = *sampling.record;
  const double moving = 0.02 * e.velocity.abs().maxCoeff();  // a stop is below 2 % of the largest speed
  Eigen::ArrayXd state(e.rows());
  double z = 0;
  for (Eigen::Index k = 0; k < e.rows(); ++k) {
    const double side = e.velocity[k] > moving ? 1 : e.velocity[k] < -moving ? -1 : 0;
    if (k > 0) z = side + (z - side) * std::exp(-(e.time[k] - e.time[k - 1]) / time_constant);
    state[k] = z;
  }
  Term t =
      sized_term(e, Shape::exponential, "decays exponentially after each stop", sampling.averaged(state));
  t.effect.numbers["time_constant"] = time_constant;
  return t;
}

Term settling_term(const Sampling& sampling, double time_constant) {
  const Evidence& e = *sampling.record;
  Eigen::ArrayXXd states = Eigen::ArrayXXd::Zero(e.rows(), 2);
  double level = 0, side = 0;
  for (Eigen::Index k = 1; k < e.rows(); ++k) {
    level *= std::exp(-(e.time[k] - e.time[k - 1]) / time_constant);
    if (e.direction[k] != e.direction[k - 1] && e.direction[k - 1] != 0) level = 1, side = e.direction[k];
    if (side != 0) states(k, side > 0 ? 0 : 1) = level;
  }
  Eigen::ArrayXXd columns(static_cast<Eigen::Index>(sampling.groups.size()), 2);
  columns << sampling.averaged(states.col(0)), sampling.averaged(states.col(1));
  Term t =
      unnamed_term(e, Shape::exponential, "decays exponentially after each reversal", std::move(columns));
  t.effect.numbers["time_constant"] = time_constant;
  return t;
}

Term state_pattern_term(const Sampling& sampling) {
  const Evidence& e = *sampling.record;
  Eigen::ArrayXXd columns(static_cast<Eigen::Index>(sampling.groups.size()), 3);
  const auto pattern = [](double edge) -> Eigen::Array3d {
    const auto state = static_cast<int>(edge - 4 * std::floor(edge / 4));
    const double half = state % 2 == 0 ? 1 : -1;
    return {half, state == 0 ? 1.0 : state == 2 ? -1.0 : 0.0, state == 1 ? 1.0 : state == 3 ? -1.0 : 0.0};
  };
  // The edge between the counts k - 1 and k has the number k. A reading's mean position is the middle of its
  // two edges.
  for (std::size_t g = 0; g < sampling.groups.size(); ++g) {
    const RowGroup& rows = sampling.groups[g];
    const double first = std::round(e.measured[rows.first] / e.step()),
                 last = std::round(e.measured[rows.end - 1] / e.step());
    Eigen::Array3d shift;
    if (std::abs(first - last) == 1)
      shift = pattern(std::max(first, last));
    else
      shift = 0.25 * (pattern(first) + pattern(first + 1) + pattern(last) + pattern(last + 1));
    columns.row(static_cast<Eigen::Index>(g)) = -e.step() * shift.transpose();
  }
  return unnamed_term(e, Shape::by_count, "repeats every four counts", std::move(columns));
}

}  // namespace qerr
