#include "diagnose/inference/select.hpp"

#include <algorithm>
#include <cmath>

#include "diagnose/inference/model_choice.hpp"
#include "diagnose/inference/unnamed_residual.hpp"
#include "diagnose/terms/scan.hpp"

namespace qerr {

namespace {

constexpr std::size_t tried_in_full = 8;  ///< candidates that are fitted, not only scored (convention)
constexpr double worth_refining = 200;    ///< largest log-likelihood deficit to the leading term (convention)
constexpr int most_slips = 5;

bool possible(const Explanation& m, std::size_t term) {
  return !m.terms()[term].positive || m.coefficients(term)[0] > 0;
}

/// Without readings near an edge an offset is not identifiable.
bool is_known(const Explanation& m, std::size_t term) {
  if (!m.terms()[term].constant) return true;
  return std::abs(m.coefficients(term)[0]) * std::sqrt(m.likelihood().curvature.sum()) > 2;
}

class Search {
 public:
  Search(const Evidence& e, const SelectOptions& options)
      : e_(e), options_(options), named_(named_terms(e)) {}

  /// The model with the term that improves it most; empty if no term does. With `names_first`, an unnamed
  /// term or step is accepted only if no combination of named terms fits as well: a free order between two
  /// named orders can fit better than either alone.
  std::optional<Explanation> better(const Explanation& model) const {
    std::optional<Explanation> next = step(model, true);
    if (!options_.names_first || !next || is_certain(*next)) return next;
    Explanation names = completed(model), others = completed(std::move(*next));
    const bool enough =
        names.terms().size() > model.terms().size() && bayes(names, e_) > bayes(others, e_) - worth_unnamed;
    return enough ? std::move(names) : std::move(others);
  }

  const std::vector<Term>& named() const { return named_; }

 private:
  /// The model with all named terms that improve it.
  Explanation completed(Explanation model) const {
    while (model.terms().size() < options_.most_terms()) {
      std::optional<Explanation> next = step(model, false);
      if (!next) break;
      model = std::move(*next);
    }
    return model;
  }

  /// Whether the last term is specific: step terms and free orders can mimic any slow drift.
  static bool is_certain(const Explanation& m) {
    const Term& last = m.terms().back();
    return last.named() && !last.step;
  }

  /// The model with one more term, or the steps that improve it most.
  /// @param any  also unnamed terms, and steps
  std::optional<Explanation> step(const Explanation& model, bool any) const {
    std::vector<Explanation> tried;
    double leading = bayes(model, e_) + worth_a_term;
    for (const Term& t : promising(model)) {
      tried.push_back(with_term(model, t));
      leading = std::max(leading, bayes(tried.back(), e_));
    }
    double value = bayes(model, e_) + worth_a_term;
    std::optional<Explanation> best;
    if (any) best = stepped(model);
    if (best) value = std::max(value, bayes(*best, e_));
    for (Explanation& next : tried) {
      // The search for the shape is expensive: only for terms that could still lead.
      if (next.terms().back().reshaped && bayes(next, e_) > leading - worth_refining)
        next = settled(refined(std::move(next), e_), e_);
      const bool is_named = next.terms().back().named();
      const double score = bayes(next, e_) - (is_named ? 0 : worth_unnamed);
      if ((!is_named && !any) || score < value || !passes(model, next)) continue;
      value = score;
      best = std::move(next);
    }
    return best;
  }

  /// Terms by the log-likelihood gain of one Newton step, the largest first.
  std::vector<Term> promising(const Explanation& model) const {
    std::vector<Term> candidates;
    for (const Term& t : named_)
      if (!has(model, t.effect)) candidates.push_back(t);
    if (auto order = strongest_order(e_, model)) {
      for (Term& integer : at_whole_orders(e_, *order))
        if (!has(model, integer.effect) && !is_listed(integer)) candidates.push_back(std::move(integer));
      candidates.push_back(std::move(*order));
    }
    std::vector<std::pair<double, std::size_t>> gains;
    for (std::size_t i = 0; i < candidates.size(); ++i)
      if (const double gain = model.gain(candidates[i]); gain > worth_trying * e_.rows_per_reading)
        gains.emplace_back(gain, i);
    std::sort(gains.rbegin(), gains.rend());
    if (gains.size() > tried_in_full) gains.resize(tried_in_full);
    std::vector<Term> best;
    for (const auto& [gain, i] : gains) best.push_back(std::move(candidates[i]));
    return best;
  }

  /// The model with counts lost or gained at one or several times. The steps are added together, as a single
  /// step fits a staircase poorly.
  std::optional<Explanation> stepped(const Explanation& model) const {
    std::optional<Explanation> best;
    Explanation m = model;
    for (int i = 0; i < most_slips; ++i) {
      const auto step = strongest_step(e_, m);
      if (!step || m.gain(*step) < worth_trying * e_.rows_per_reading) break;
      Explanation next = with_term(m, *step);
      const bool passed = bayes(next, e_) > bayes(m, e_) + worth_a_term && passes(m, next);
      m = std::move(next);
      if (!passed) continue;
      relocate_steps(m, model.terms().size());
      best = m;
    }
    return best;
  }

  /// Re-estimates the time of each step, given the others.
  void relocate_steps(Explanation& m, std::size_t first) const {
    for (std::size_t i = first; i + 1 < m.terms().size(); ++i) {
      // Rotate, so that each step is refitted.
      Explanation without = without_term(m, first);
      const auto step = strongest_step(e_, without);
      const Term before = m.terms()[first];
      Explanation same = with_term(without, before);
      Explanation moved = step ? with_term(std::move(without), *step) : same;
      m = moved.log_likelihood() > same.log_likelihood() ? std::move(moved) : std::move(same);
    }
  }

  bool passes(const Explanation& model, const Explanation& next) const {
    const std::size_t last = next.terms().size() - 1;
    const Term& t = next.terms()[last];
    const bool scanned = !t.named() || t.step || !is_listed(t);
    if (!possible(next, last) || !is_known(next, last)) return false;
    if (size_of(next, last) < (scanned ? options_.least_scanned(e_) : options_.least(e_))) return false;
    const double tests = static_cast<double>(named_.size()) * (scanned ? scanned_hypotheses : 1);
    return p_value(model, next, last) * tests < options_.alpha;
  }

  bool is_listed(const Term& t) const {
    return t.reshaped || std::any_of(named_.begin(), named_.end(),
                                     [&](const Term& n) { return same_cause(n.effect, t.effect); });
  }

  const Evidence& e_;
  SelectOptions options_;
  std::vector<Term> named_;
};

/// Drops terms that are no longer significant together with those added later.
void prune(Explanation& m, const Evidence& e, const SelectOptions& options) {
  for (std::size_t i = m.terms().size(); i-- > 0;) {
    Explanation without = without_term(m, i);
    if (bayes(without, e) > bayes(m, e) - worth_a_term || p_value(without, m, i) > options.alpha ||
        size_of(m, i) < options.least(e) || !possible(m, i) || !is_known(m, i))
      m = std::move(without);
  }
}

/// Mean square residual in excess of noise and quantization. Candidates that differ by less are not
/// distinguishable.
double unmodelled_variance(const Explanation& m, const Evidence& e) {
  if (e.rows_per_reading <= 1) return 0;
  return std::max(0.0, mean_square_residual(m, e) - e.step() * e.step() / 12 - e.noise * e.noise);
}

/// Adds the terms that could replace a chosen one: with nearly the same likelihood or explained variance.
void add_alternatives(Selection& s, std::size_t term, const Explanation& without, const Evidence& e,
                      const std::vector<Term>& named) {
  const double all = (e.measured - e.reference).square().mean();
  const double removed = mean_square_residual(without, e) - mean_square_residual(s.model, e);
  const double chosen = without.gain(s.model.terms()[term]);
  const double unknown = unmodelled_variance(s.model, e);
  for (const Term& other : named) {
    if (has(s.model, other.effect) || without.gain(other) < worth_comparing * chosen) continue;
    const Explanation swapped = with_term(without, other);
    const double loss = bayes(s.model, e) - bayes(swapped, e);
    const double part =
        removed > 0 ? (mean_square_residual(without, e) - mean_square_residual(swapped, e)) / removed : 0;
    const double lost = mean_square_residual(swapped, e) - mean_square_residual(s.model, e);
    const bool near = loss < similar_loss && part > similar_part && removed > 0.01 * all;
    if (loss < indistinguishable_loss || near || lost < unknown)
      s.alternatives.push_back({term, other.effect, loss});
  }
}

}  // namespace

Selection select(const Evidence& e, const SelectOptions& options) {
  const Search search(e, options);
  Explanation model(e);
  while (model.terms().size() < options.most_terms()) {
    std::optional<Explanation> next = search.better(model);
    if (!next) break;
    model = std::move(*next);
  }
  prune(model, e, options);
  add_unnamed_residual(model, e, options);
  prune(model, e, options);
  Selection s{std::move(model), {}, {}};
  for (std::size_t i = 0; i < s.model.terms().size(); ++i) {
    const Explanation without = without_term(s.model, i);
    s.p_values.push_back(p_value(without, s.model, i));
    if (s.model.terms()[i].named()) add_alternatives(s, i, without, e, search.named());
  }
  return s;
}

}  // namespace qerr
