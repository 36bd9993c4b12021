#include "diagnose/inference/unnamed_residual.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/solve.hpp"
#include "core/statistics.hpp"
#include "diagnose/inference/model_choice.hpp"
#include "diagnose/terms/scan.hpp"
#include "diagnose/terms/unnamed_terms.hpp"

namespace qerr {

namespace {

constexpr double shadow = 0.1;      ///< of what is explained: a name that brings less beside a remainder
constexpr double cancelling = 1.6;  ///< times the residual: two terms that undo each other
constexpr double small_remainder = 0.15;  ///< of what is explained
constexpr Eigen::Index rows_a_knot = 25;

/// Tables from coarse to fine, as fine as the rows allow.
std::vector<Term> tables(const Evidence& e) {
  std::vector<Term> all;
  for (const Eigen::Index knots : {24, 64})
    if (!e.is_stationary() && e.rows() >= rows_a_knot * knots) all.push_back(position_table_term(e, knots));
  if (e.ordered)
    for (const Eigen::Index knots : {24, 64, 160})
      if (e.rows() >= rows_a_knot * knots) all.push_back(time_table_term(e, knots));
  if (all.empty() && !e.is_stationary() && e.rows() >= 160)
    all.push_back(position_table_term(e, e.rows() / 40));
  return all;
}

/// The table that promises most, after what its knots cost.
std::optional<Term> best_table(const Explanation& m, const Evidence& e) {
  std::optional<Term> best;
  double value = worth_no_name;
  for (Term& t : tables(e)) {
    const double here = m.gain(t) / e.rows_per_reading -
                        0.5 * static_cast<double>(t.size()) * std::log(e.independent_readings());
    if (here > value) value = here, best = std::move(t);
  }
  return best;
}

/// The model with the remainder that improves it most.
std::optional<Explanation> with_remainder(const Explanation& m, const Evidence& e,
                                          const SelectOptions& options) {
  std::vector<Term> candidates;
  if (auto table = best_table(m, e)) candidates.push_back(std::move(*table));
  if (auto vibration = strongest_vibration(e, m)) candidates.push_back(std::move(*vibration));
  std::optional<Explanation> best;
  double value = bayes(m, e) + worth_no_name;
  for (const Term& t : candidates) {
    if (m.gain(t) < worth_no_name * e.rows_per_reading) continue;
    Explanation next = with_term(m, t);
    if (next.terms().back().reshaped) next = refined(std::move(next), e);
    const std::size_t last = next.terms().size() - 1;
    if (size_of(next, last) < options.least_scanned(e)) continue;
    if (p_value(m, next, last) * scanned_hypotheses > options.alpha) continue;
    if (const double here = bayes(next, e); here > value) value = here, best = std::move(next);
  }
  return best;
}

/// A loss of counts is of whole counts.
bool is_whole(const Explanation& m, std::size_t term) {
  const double counts = m.coefficients(term)[0];
  return std::round(counts) != 0 && std::abs(counts - std::round(counts)) < 0.15;
}

bool is_periodic(const Term& t) { return t.named() && t.harmonic; }

/// Periods of a term that the record has seen.
double periods_seen(const Term& t, const Evidence& e) {
  const double range = e.path.maxCoeff() - e.path.minCoeff();
  return std::abs(wave_number(t.effect, e.encoder)) * range / (2 * std::numbers::pi);
}

/// Two parts of periods are no two orders, and three orders on two turns are a series: such sums make any
/// smooth curve, and none of their terms is known.
void drop_bends(Explanation& m, const Evidence& e) {
  std::ptrdiff_t periodic = 0, parts = 0, few = 0;
  for (const Term& t : m.terms())
    if (is_periodic(t)) {
      ++periodic;
      parts += periods_seen(t, e) < 0.9;
      few += periods_seen(t, e) < 2;
    }
  const bool series = periodic >= 3 && few > 0;
  if (!series && parts < 2) return;
  for (std::size_t i = m.terms().size(); i-- > 0;)
    if (is_periodic(m.terms()[i]) && (series || periods_seen(m.terms()[i], e) < 0.9)) m.remove(i);
  m.fit();
}

/// Names whose sizes say that they are none: steps of broken counts, and pairs that take off what the other
/// adds. The worst goes first, and the others are fitted anew.
void drop_impossible(Explanation& m, const Evidence& e) {
  const Eigen::ArrayXd residual = e.measured - e.reference;
  const double most = cancelling * standard_deviation(residual);
  for (bool found = true; found;) {
    std::size_t worst = 0;
    double size = 0;
    found = false;
    for (std::size_t i = 0; i < m.terms().size(); ++i) {
      const Term& t = m.terms()[i];
      if (t.whole ? is_whole(m, i) : t.constant || size_of(m, i) < most) continue;
      if (size_of(m, i) < size) continue;
      size = size_of(m, i), worst = i, found = true;
    }
    if (found) m = without_term(m, worst);
  }
}

/// What the terms with a name leave by themselves.
double left_by_names(Explanation m, const Evidence& e) {
  for (std::size_t i = m.terms().size(); i-- > 0;)
    if (!m.terms()[i].named()) m.remove(i);
  m.fit();
  return left_by(m, e);
}

/// A remainder less what the names can make of it: beside names that explain nearly all, it is what they
/// leave, and takes nothing off them.
Term beside(const Explanation& m, Term remainder) {
  Eigen::Index count = 1;
  for (const Term& t : m.terms()) count += t.size();
  Eigen::MatrixXd names = Eigen::MatrixXd::Ones(remainder.columns.rows(), count);
  Eigen::Index at = 1;
  for (const Term& t : m.terms()) {
    names.middleCols(at, t.size()) = t.columns.matrix();
    at += t.size();
  }
  names = names * names.colwise().norm().cwiseMax(1e-300).cwiseInverse().asDiagonal();
  const Eigen::MatrixXd q = orthonormal_basis(names);
  Eigen::ArrayXXd left = remainder.columns - (q * (q.transpose() * remainder.columns.matrix())).array();
  return with_columns(std::move(remainder), std::move(left));
}

/// Names that bring little beside a remainder that brings much were only its likeness.
void drop_shadows(Explanation& m, const Evidence& e) {
  if (std::all_of(m.terms().begin(), m.terms().end(), [](const Term& t) { return t.named(); })) return;
  const double left = left_by(m, e), explained = (e.measured - e.reference).square().mean() - left;
  if (left_by_names(m, e) - left < small_remainder * explained) return;
  for (std::size_t i = m.terms().size(); i-- > 0;) {
    const Term& t = m.terms()[i];
    if (!t.named() || t.constant) continue;
    Explanation without = without_term(m, i);
    if (left_by(without, e) - left_by(m, e) < shadow * explained) m = std::move(without);
  }
}

}  // namespace

void add_remainder(Explanation& m, const Evidence& e, const SelectOptions& options) {
  if (!options.names_first) drop_bends(m, e);
  drop_impossible(m, e);
  if (auto next = with_remainder(m, e, options)) {
    const double left = left_by(*next, e);
    if (left_by(m, e) - left < small_remainder * ((e.measured - e.reference).square().mean() - left))
      next = with_term(m, beside(m, next->terms().back()));
    m = std::move(*next);
  }
  drop_shadows(m, e);
  drop_impossible(m, e);
}

}  // namespace qerr
