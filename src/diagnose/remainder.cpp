#include "remainder.hpp"

#include <algorithm>
#include <cmath>

#include "model_choice.hpp"
#include "scan.hpp"

namespace qerr {

namespace {

constexpr double worth_no_name = 10;  ///< what has no name must be clearly better
constexpr double shadow = 0.1;        ///< of what is explained: a name that brings less beside a remainder
constexpr Eigen::Index rows_a_knot = 25;

/// Tables from coarse to fine, as fine as the rows allow.
std::vector<Term> tables(const Evidence& e) {
  std::vector<Term> all;
  for (const Eigen::Index knots : {24, 64})
    if (e.rows() >= rows_a_knot * knots) all.push_back(position_table_term(e, knots));
  if (e.ordered)
    for (const Eigen::Index knots : {24, 64, 160})
      if (e.rows() >= rows_a_knot * knots) all.push_back(time_table_term(e, knots));
  if (all.empty() && e.rows() >= 160) all.push_back(position_table_term(e, e.rows() / 40));
  return all;
}

/// The table that promises most, after what its knots cost.
std::optional<Term> best_table(const Explanation& m, const Evidence& e) {
  std::optional<Term> best;
  double value = worth_no_name;
  for (Term& t : tables(e)) {
    const double here =
        m.gain(t) - 0.5 * static_cast<double>(t.size()) * std::log(static_cast<double>(e.rows()));
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
    if (m.gain(t) < worth_no_name) continue;
    Explanation next = with_term(m, t);
    if (next.terms().back().reshaped) next = refined(std::move(next), e);
    const std::size_t last = next.terms().size() - 1;
    if (size_of(next, last) < options.least_scanned(e)) continue;
    if (p_value(m, next, last) * scanned_hypotheses > options.alpha) continue;
    if (const double here = bayes(next, e); here > value) value = here, best = std::move(next);
  }
  return best;
}

bool is_shadow(const Term& t) { return t.named() && t.effect.type != "offset"; }

/// Names that bring little beside a remainder that brings much were only its likeness.
void drop_shadows(Explanation& m, const Evidence& e, double left_by_names) {
  const double left = left_by(m, e), without_any = (e.measured - e.reference).square().mean();
  const double explained = without_any - left;
  if (left_by_names - left < shadow * explained) return;
  for (std::size_t i = m.terms().size() - 1; i-- > 0;) {
    if (!is_shadow(m.terms()[i])) continue;
    Explanation without = without_term(m, i);
    if (left_by(without, e) - left_by(m, e) < shadow * explained) m = std::move(without);
  }
}

}  // namespace

void add_remainder(Explanation& m, const Evidence& e, const SelectOptions& options) {
  const double left_by_names = left_by(m, e);
  std::optional<Explanation> next = with_remainder(m, e, options);
  if (!next) return;
  m = std::move(*next);
  drop_shadows(m, e, left_by_names);
}

}  // namespace qerr
