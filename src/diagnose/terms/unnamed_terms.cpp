#include "diagnose/terms/unnamed_terms.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

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

Term unnamed_term(const RecordSignals& s, std::string what, Eigen::ArrayXXd columns) {
  Term t;
  t.effect = {"", s.joint, {}, {}};
  t.columns = std::move(columns);
  t.fill = [](Effect&, const Eigen::VectorXd&) {};
  t.unnamed = std::move(what);
  return t;
}

}  // namespace

Term position_table_term(const RecordSignals& s, Eigen::Index knots) {
  return unnamed_term(s, "repeats with the position, without a period", hats(s.path, knots));
}

Term time_table_term(const RecordSignals& s, Eigen::Index knots) {
  return unnamed_term(s, "slow in time", hats(s.time, knots));
}

Term vibration_term(const RecordSignals& s, double frequency) {
  const Eigen::ArrayXd angle = 2 * std::numbers::pi * frequency * s.time;
  Eigen::ArrayXXd columns(s.rows(), 2);
  columns << angle.sin(), angle.cos();
  Term t = unnamed_term(s, "vibrates", std::move(columns));
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

}  // namespace qerr
