#include "diagnose/inference/model_choice.hpp"

#include <algorithm>
#include <cmath>

#include "core/probability.hpp"
#include "core/statistics.hpp"
#include "diagnose/terms/scan.hpp"

namespace qerr {

namespace {

/// Derivative of a term with respect to its shape, by central differences.
Term shape_change(const Evidence& e, const Term& t, const Eigen::VectorXd& coefficients) {
  const double change = 1e-3 * t.half_width;
  const Eigen::ArrayXXd by =
      t.reshaped(e, t, t.shape + change).columns - t.reshaped(e, t, t.shape - change).columns;
  return with_columns(t, (by.matrix() * coefficients).array() / (2 * change));
}

/// The shape within the search half-width with the largest gain of one Newton step, by golden section.
Term most_promising(const Explanation& without, const Evidence& e, const Term& start) {
  const auto gain_at = [&](double shape) { return without.gain(start.reshaped(e, start, shape)); };
  constexpr double golden = 0.6180339887498949;
  double low = start.shape - start.half_width, high = start.shape + start.half_width;
  double left = high - golden * (high - low), right = low + golden * (high - low);
  double at_left = gain_at(left), at_right = gain_at(right);
  for (int i = 0; i < 14; ++i) {
    if (at_left > at_right) {
      high = right, right = left, at_right = at_left;
      at_left = gain_at(left = high - golden * (high - low));
    } else {
      low = left, left = right, at_left = at_right;
      at_right = gain_at(right = low + golden * (high - low));
    }
  }
  return start.reshaped(e, start, at_left > at_right ? left : right);
}

}  // namespace

double bayes(const Explanation& m, const Evidence& e) {
  Eigen::Index count = 0;
  for (const Term& t : m.terms()) count += t.size() + (t.reshaped || t.step ? 1 : 0);
  return m.log_likelihood() / e.rows_per_reading -
         0.5 * static_cast<double>(count) * std::log(e.independent_readings());
}

double p_value(const Explanation& without, const Explanation& with, std::size_t term) {
  const Term& t = with.terms()[term];
  const double ratio =
      2 * (with.log_likelihood() - without.log_likelihood()) / with.variance_inflation(t.columns);
  return ratio > 0 ? chi_squared_tail(ratio, static_cast<double>(t.size())) : 1;
}

double size_of(const Explanation& m, std::size_t term) {
  const Eigen::ArrayXd added = addition(m.terms()[term], m.coefficients(term));
  return m.terms()[term].constant ? std::abs(added.mean()) : standard_deviation(added);
}

double mean_square_residual(const Explanation& m, const Evidence& e) {
  return (e.measured - e.reference - m.addition()).square().mean();
}

Explanation with_term(Explanation m, Term t) {
  m.add(std::move(t));
  m.fit();
  return m;
}

Explanation without_term(Explanation m, std::size_t term) {
  m.remove(term);
  m.fit();
  return m;
}

Explanation with_term_at(const Explanation& m, std::size_t term, Term t) {
  Explanation next = m;
  next.remove(term);
  return with_term(std::move(next), std::move(t));
}

bool same_cause(const Effect& a, const Effect& b) {
  return same_but_for_time(a, b) && a.number_or("time_constant", 0) == b.number_or("time_constant", 0) &&
         a.number_or("time", 0) == b.number_or("time", 0);
}

bool same_but_for_time(const Effect& a, const Effect& b) {
  return a.type == b.type && a.choices == b.choices && a.number_or("order", 0) == b.number_or("order", 0);
}

bool has(const Explanation& m, const Effect& effect) {
  return std::any_of(m.terms().begin(), m.terms().end(),
                     [&](const Term& t) { return same_cause(t.effect, effect); });
}

Explanation refined(Explanation m, const Evidence& e) {
  const std::size_t last = m.terms().size() - 1;
  const Term start = m.terms().back();
  if (!start.reshaped) return m;
  const Explanation without = without_term(m, last);
  Explanation best = with_term(without, most_promising(without, e, start));
  if (m.log_likelihood() > best.log_likelihood()) best = std::move(m);
  // Newton's method with the shape as one more coefficient.
  for (int i = 0; i < 3; ++i) {
    const Term now = best.terms()[last];
    const Explanation linear = with_term(best, shape_change(e, now, best.coefficients(last)));
    const double change =
        std::clamp(linear.coefficients(last + 1)[0], -0.5 * now.half_width, 0.5 * now.half_width);
    Explanation next = with_term(without, now.reshaped(e, now, now.shape + change));
    const double better = next.log_likelihood() - best.log_likelihood();
    if (better <= 0) break;
    best = std::move(next);
    if (better < 0.05) break;
  }
  return best;
}

Explanation settled(Explanation m, const Evidence& e) {
  const Term last = m.terms().back();
  if (last.named() || !last.harmonic) return m;
  std::optional<Explanation> best;
  for (const Term& whole : at_whole_orders(e, last)) {
    if (has(m, whole.effect)) continue;
    Explanation named = with_term_at(m, m.terms().size() - 1, whole);
    // Integer orders within 2 % of the half-width are accepted at a larger loss: smoothing limits the order.
    const double order = std::abs(wave_number(whole.effect, e.encoder));
    const bool near = std::abs(order - last.shape) < 0.02 * last.half_width;
    const double lost = m.log_likelihood() - named.log_likelihood();
    if (lost > (near ? similar_loss : worth_a_term) * e.rows_per_reading) continue;
    if (!best || named.log_likelihood() > best->log_likelihood()) best = std::move(named);
  }
  return best ? std::move(*best) : std::move(m);
}

}  // namespace qerr
