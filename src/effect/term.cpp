#include "effect/term.hpp"

#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/statistics.hpp"
#include "qerr/effect/effect_kind.hpp"

namespace qerr {

namespace {

/// Reversals of a signal by more than a width.
Eigen::Index turns(const Eigen::ArrayXd& x, double width) {
  Eigen::Index count = 0;
  double side = 0, extreme = x[0];
  for (const double value : x) {
    const double by = value - extreme;
    if (side == 0 ? std::abs(by) > width : side * by < -width) {
      count += side != 0;
      side = by > 0 ? 1 : -1;
      extreme = value;
    } else if (side * by > 0) {
      extreme = value;
    }
  }
  return count;
}

}  // namespace

bool RecordSignals::readings_drive(double gap) const {
  constexpr double counts = 3, quiet = 1.5;
  if (coupled() || measured.size() != rows() || !(gap > counts * step())) return false;
  constexpr double half = 0.5;  // between two directions, of -1 and 1
  return turns(measured, quiet * step()) <= 2 * turns(direction, half) + 4;
}

Eigen::ArrayXd RecordSignals::drive(double gap) const {
  const double ratio = fit_line(path, measured).slope;
  const bool is_of_play = std::abs(ratio - 1) * standard_deviation(path) <= 0.5 * gap;
  return ratio > 0 && !is_of_play ? (measured / ratio).eval() : measured;
}

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

Term linear_term(const RecordSignals& s, std::string_view effect, Eigen::ArrayXd column,
                 void (*fill)(Effect&, const Eigen::VectorXd&)) {
  Term t;
  t.effect = {std::string(effect), s.joint, {}, {}};
  t.columns = std::move(column);
  t.fill = fill;
  return t;
}

std::vector<Term> named_terms(const RecordSignals& s) {
  std::vector<Term> all;
  for (const EffectKind& kind : effect_kinds())
    if (kind.terms)
      for (Term& t : kind.terms(s)) all.push_back(std::move(t));
  return all;
}

Term step_term(const RecordSignals& s, double time) {
  for (const EffectKind& kind : effect_kinds())
    if (kind.step_at) return kind.step_at(s, time);
  throw std::logic_error("no effect has a step term");
}

}  // namespace qerr
