#include "diagnose/terms/subdivision.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace qerr {

namespace {

// Coefficients, in this order; the last one only of signals that are clipped.
constexpr std::array<const char*, 5> parameters{"offset_sin", "offset_cos", "gain", "phase", "clipping"};
constexpr Eigen::Index clipping = 4;
constexpr double most = 0.9, least_clipping = 0.2;

/// Parameters that a fit may pass on its way, brought back to where the effect is defined.
Eigen::VectorXd within_reason(Eigen::VectorXd p) {
  for (Eigen::Index i = 0; i < p.size(); ++i)
    p[i] = i == clipping ? std::clamp(p[i], least_clipping, 1.0) : std::clamp(p[i], -most, most);
  return p;
}

void fill(Effect& e, const Eigen::VectorXd& coefficients) {
  const Eigen::VectorXd p = within_reason(coefficients);
  e.numbers["clipping"] = 1;
  for (Eigen::Index i = 0; i < p.size(); ++i) e.numbers[parameters[static_cast<std::size_t>(i)]] = p[i];
}

Eigen::ArrayXd made_of(const Evidence& e, const Term& t, const Eigen::VectorXd& p) {
  Effect effect = t.effect;
  fill(effect, p);
  const Action action = effect_kind("subdivision_error").action(effect, e.encoder, 0);
  const Eigen::ArrayXd path = t.moved.size() > 0 ? Eigen::ArrayXd(e.path + t.moved) : e.path;
  return path.unaryExpr([&](double x) { return action(x, {}) - x; });
}

Term about(const Evidence& e, const Term& t, const Eigen::VectorXd& coefficients) {
  constexpr double change = 1e-4;
  Term next = t;
  const Eigen::VectorXd p = within_reason(coefficients);
  next.columns.resize(e.rows(), p.size());
  for (Eigen::Index i = 0; i < p.size(); ++i) {
    const Eigen::VectorXd step = change * Eigen::VectorXd::Unit(p.size(), i);
    // Signals that are just whole can only be clipped more.
    const Eigen::VectorXd more = i == clipping && p[i] + change > 1 ? p : Eigen::VectorXd(p + step);
    next.columns.col(i) = (made_of(e, t, more) - made_of(e, t, p - step)) / (more[i] - p[i] + change);
  }
  if (!p.isZero()) next.fixed = made_of(e, t, p) - (next.columns.matrix() * p).array();
  return next;
}

/// The slope is taken anew where the fit has ended: here only its path is noted.
Term along(const Evidence&, const Term& t, const Eigen::ArrayXd& moved) {
  Term next = t;
  next.moved = moved;
  return next;
}

}  // namespace

std::vector<Term> subdivision_terms(const Evidence& e) {
  Term whole;
  whole.effect = {"subdivision_error", e.joint, {{"clipping", 1.0}}, {}};
  whole.fill = fill;
  whole.relinearized = about;
  whole.along = along;
  Eigen::VectorXd p = Eigen::VectorXd::Zero(parameters.size());
  std::vector<Term> terms{about(e, whole, p.head(clipping))};
  // Where a slope leads depends on where it is taken: between what is just seen and what real resolvers show.
  for (const double level : {0.95, 0.75}) {
    p[clipping] = level;
    terms.push_back(about(e, whole, p));
  }
  return terms;
}

}  // namespace qerr
