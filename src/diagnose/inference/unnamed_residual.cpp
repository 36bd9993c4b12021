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

constexpr double shadow =
    0.1;  ///< fraction of the explained variance below which a name beside an unnamed term is dropped
constexpr double cancelling = 1.6;        ///< times the residual's rms: larger terms cancel each other
constexpr double small_remainder = 0.15;  ///< fraction of the explained variance
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

/// The table with the largest expected gain, less the Bayesian price of its knots.
std::optional<Term> best_table(const Explanation& m, const Evidence& e) {
  std::optional<Term> best;
  double value = worth_unnamed;
  for (Term& t : tables(e)) {
    const double here = m.gain(t) / e.rows_per_reading -
                        0.5 * static_cast<double>(t.size()) * std::log(e.independent_readings());
    if (here > value) value = here, best = std::move(t);
  }
  return best;
}

/// The model with the unnamed term that improves it most.
std::optional<Explanation> with_unnamed_term(const Explanation& m, const Evidence& e,
                                             const SelectOptions& options) {
  std::vector<Term> candidates;
  if (auto table = best_table(m, e)) candidates.push_back(std::move(*table));
  if (auto vibration = strongest_vibration(e, m)) candidates.push_back(std::move(*vibration));
  std::optional<Explanation> best;
  double value = bayes(m, e) + worth_unnamed;
  for (const Term& t : candidates) {
    if (m.gain(t) < worth_unnamed * e.rows_per_reading) continue;
    Explanation next = with_term(m, t);
    if (next.terms().back().reshaped) next = refined(std::move(next), e);
    const std::size_t last = next.terms().size() - 1;
    if (size_of(next, last) < options.least_scanned(e)) continue;
    if (p_value(m, next, last) * scanned_hypotheses > options.alpha) continue;
    if (const double here = bayes(next, e); here > value) value = here, best = std::move(next);
  }
  return best;
}

/// Counts are lost in whole numbers.
bool is_whole(const Explanation& m, std::size_t term) {
  const double counts = m.coefficients(term)[0];
  return std::round(counts) != 0 && std::abs(counts - std::round(counts)) < 0.15;
}

bool is_periodic(const Term& t) { return t.named() && t.harmonic; }

/// Periods of a term that the record covers.
double periods_seen(const Term& t, const Evidence& e) {
  const double range = e.path.maxCoeff() - e.path.minCoeff();
  return std::abs(wave_number(t.effect, e.encoder)) * range / (2 * std::numbers::pi);
}

/// Fractional periods cannot establish distinct orders: two of them, or three orders over two periods, fit
/// any smooth curve as a truncated series does, and none of their terms is identified.
void drop_partial_periods(Explanation& m, const Evidence& e) {
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

/// Drops names of impossible size: steps of fractional counts, and pairs that cancel each other. The largest
/// is dropped first, and the others are refitted.
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

/// Mean square residual of the named terms alone.
double residual_of_names(Explanation m, const Evidence& e) {
  for (std::size_t i = m.terms().size(); i-- > 0;)
    if (!m.terms()[i].named()) m.remove(i);
  m.fit();
  return mean_square_residual(m, e);
}

/// An unnamed term, orthogonal to the named ones: it then fits their residual alone, and does not change
/// their coefficients.
Term orthogonal_to_names(const Explanation& m, Term remainder) {
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

/// Drops names whose effect the unnamed term absorbs.
void drop_absorbed_names(Explanation& m, const Evidence& e) {
  if (std::all_of(m.terms().begin(), m.terms().end(), [](const Term& t) { return t.named(); })) return;
  const double left = mean_square_residual(m, e),
               explained = (e.measured - e.reference).square().mean() - left;
  if (residual_of_names(m, e) - left < small_remainder * explained) return;
  for (std::size_t i = m.terms().size(); i-- > 0;) {
    const Term& t = m.terms()[i];
    if (!t.named() || t.constant) continue;
    Explanation without = without_term(m, i);
    if (mean_square_residual(without, e) - mean_square_residual(m, e) < shadow * explained)
      m = std::move(without);
  }
}

}  // namespace

void add_unnamed_residual(Explanation& m, const Evidence& e, const SelectOptions& options) {
  if (!options.names_first) drop_partial_periods(m, e);
  drop_impossible(m, e);
  if (auto next = with_unnamed_term(m, e, options)) {
    const double left = mean_square_residual(*next, e);
    if (mean_square_residual(m, e) - left <
        small_remainder * ((e.measured - e.reference).square().mean() - left))
      next = with_term(m, orthogonal_to_names(m, next->terms().back()));
    m = std::move(*next);
  }
  drop_absorbed_names(m, e);
  drop_impossible(m, e);
}

}  // namespace qerr
