#include "select.hpp"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>

#include "scan.hpp"

namespace qerr {

namespace {

constexpr int tried_in_full = 6;
constexpr double worth_a_term = 3;       ///< in the Bayesian criterion
constexpr double worth_refining = 200;   ///< behind the leading term at most
constexpr double worth_no_name = 10;     ///< what has no name must be clearly better
constexpr double cannot_be_told = 6;     ///< loss of an alternative
constexpr double nearly_as_good = 0.96;  ///< of the variance that a cause explains

double bayes(const Explanation& m, const Evidence& e) {
  Eigen::Index count = 0;
  for (const Term& t : m.terms()) count += t.size();
  return m.log_likelihood() - 0.5 * static_cast<double>(count) * std::log(static_cast<double>(e.rows()));
}

Eigen::ArrayXd addition(const Explanation& m, std::size_t term) {
  return (m.terms()[term].columns.matrix() * m.coefficients(term)).array();
}

double size(const Explanation& m, std::size_t term) {
  const Eigen::ArrayXd added = addition(m, term);
  return m.terms()[term].effect.type == "offset" ? std::abs(added.mean())
                                                 : std::sqrt((added - added.mean()).square().mean());
}

/// Of a model with a term against the one without it: the likelihood ratio, less what correlated errors make
/// of it.
double p_value(const Explanation& without, const Explanation& with, std::size_t term) {
  const Term& t = with.terms()[term];
  const double ratio = 2 * (with.log_likelihood() - without.log_likelihood()) / with.inflation(t.columns);
  return ratio > 0 ? cdf(complement(boost::math::chi_squared(static_cast<double>(t.size())), ratio)) : 1;
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

bool same(const Effect& a, const Effect& b) {
  for (const char* number : {"order", "time_constant", "time"})
    if (a.number(number) != b.number(number)) return false;
  return a.type == b.type && a.choices == b.choices;
}

bool has(const Explanation& m, const Effect& effect) {
  return std::any_of(m.terms().begin(), m.terms().end(),
                     [&](const Term& t) { return same(t.effect, effect); });
}

/// What a small change of a term's shape adds, per unit of it.
Term shape_change(const Evidence& e, const Term& t, const Eigen::VectorXd& coefficients) {
  const double change = 1e-3 * t.reach;
  Term d = t;
  d.columns =
      ((t.reshaped(e, t, t.shape + change).columns - t.reshaped(e, t, t.shape - change).columns).matrix() *
       coefficients / (2 * change))
          .array();
  d.reshaped = nullptr;
  return d;
}

/// Moves the last term's shape to where the likelihood is largest: within its reach by golden section on
/// what one Newton step would gain, then by Newton's method with the shape as one more coefficient.
Explanation refined(Explanation m, const Evidence& e) {
  const Term start = m.terms().back();
  if (!start.reshaped) return m;
  const Explanation without = without_term(m, m.terms().size() - 1);
  const auto at = [&](double shape) { return without.gain(start.reshaped(e, start, shape).columns); };
  constexpr double golden = 0.6180339887498949;
  double low = start.shape - start.reach, high = start.shape + start.reach;
  double left = high - golden * (high - low), right = low + golden * (high - low);
  double at_left = at(left), at_right = at(right);
  for (int i = 0; i < 14; ++i) {
    if (at_left > at_right) {
      high = right, right = left, at_right = at_left;
      at_left = at(left = high - golden * (high - low));
    } else {
      low = left, left = right, at_left = at_right;
      at_right = at(right = low + golden * (high - low));
    }
  }
  Explanation best = with_term(without, start.reshaped(e, start, at_left > at_right ? left : right));
  if (m.log_likelihood() > best.log_likelihood()) best = std::move(m);
  const std::size_t last = best.terms().size() - 1;
  for (int i = 0; i < 3; ++i) {
    const Term now = best.terms()[last];
    const Explanation linear = with_term(best, shape_change(e, now, best.coefficients(last)));
    const double change = std::clamp(linear.coefficients(last + 1)[0], -0.5 * now.reach, 0.5 * now.reach);
    Explanation next = with_term(without, now.reshaped(e, now, now.shape + change));
    if (next.log_likelihood() <= best.log_likelihood()) break;
    const bool done = next.log_likelihood() - best.log_likelihood() < 0.05;
    best = std::move(next);
    if (done) break;
  }
  return best;
}

/// A whole order in place of a free one, where the record lets it be.
Explanation settled(Explanation m, const Evidence& e) {
  const Term last = m.terms().back();
  if (last.named() || last.effect.type != "transmission_error") return m;
  const std::optional<Term> whole = at_whole_order(e, last);
  if (!whole || has(m, whole->effect)) return m;
  Explanation named = with_term_at(m, m.terms().size() - 1, *whole);
  return m.log_likelihood() - named.log_likelihood() < worth_a_term ? named : m;
}

class Search {
 public:
  Search(const Evidence& e, const SelectOptions& options)
      : e_(e), options_(options), named_(named_terms(e)) {}

  /// The model with the term that improves it most, if any does.
  std::optional<Explanation> better(const Explanation& model) const {
    std::vector<Term> candidates = named_;
    for (auto& scanned : {strongest_step(e_, model), strongest_order(e_, model)})
      if (scanned) candidates.push_back(*scanned);
    std::vector<std::pair<double, std::size_t>> gains;
    for (std::size_t i = 0; i < candidates.size(); ++i)
      if (const double gain = model.gain(candidates[i].columns); gain > 8) gains.emplace_back(gain, i);
    std::sort(gains.rbegin(), gains.rend());
    if (gains.size() > tried_in_full) gains.resize(tried_in_full);
    std::vector<Explanation> tried;
    double leading = bayes(model, e_) + worth_a_term;
    for (const auto& [gain, i] : gains) {
      tried.push_back(with_term(model, candidates[i]));
      leading = std::max(leading, bayes(tried.back(), e_));
    }
    std::optional<Explanation> best;
    double value = bayes(model, e_) + worth_a_term;
    for (Explanation& next : tried) {
      // Only what could still lead is worth the search for its shape.
      if (next.terms().back().reshaped && bayes(next, e_) > leading - worth_refining)
        next = settled(refined(std::move(next), e_), e_);
      const double here = bayes(next, e_) - (next.terms().back().named() ? 0 : worth_no_name);
      if (here < value || !passes(model, next)) continue;
      value = here;
      best = std::move(next);
    }
    return best;
  }

  const std::vector<Term>& named() const { return named_; }

 private:
  bool passes(const Explanation& model, const Explanation& next) const {
    const std::size_t last = next.terms().size() - 1;
    const Term& t = next.terms()[last];
    const bool scanned = !t.named() || t.effect.type == "missed_counts";
    if (size(next, last) < (scanned ? 2 : 1) * options_.least_amplitude * e_.step()) return false;
    const double tests = static_cast<double>(named_.size()) * (scanned ? scanned_hypotheses : 1);
    return p_value(model, next, last) * tests < options_.alpha;
  }

  const Evidence& e_;
  SelectOptions options_;
  std::vector<Term> named_;
};

/// Drops terms that stopped to matter when others came.
void prune(Explanation& m, const Evidence& e) {
  for (std::size_t i = m.terms().size(); i-- > 0;) {
    Explanation without = without_term(m, i);
    if (bayes(without, e) > bayes(m, e) - worth_a_term) m = std::move(without);
  }
}

/// Something real that no named cause makes: of tables of position and time and of vibrations the one that
/// improves the model most. Named terms that are not needed beside it were its shadows.
void add_remainder(Explanation& m, const Evidence& e, const SelectOptions& options) {
  std::vector<Term> candidates;
  const Eigen::Index knots = std::min<Eigen::Index>(24, e.rows() / 40);
  if (knots >= 4) candidates.push_back(position_table_term(e, knots));
  if (knots >= 4 && e.ordered) candidates.push_back(time_table_term(e, knots));
  if (auto vibration = strongest_vibration(e, m)) candidates.push_back(*vibration);
  std::optional<Explanation> best;
  double value = bayes(m, e) + worth_no_name;
  for (const Term& t : candidates) {
    Explanation next = with_term(m, t);
    if (next.terms().back().reshaped) next = refined(std::move(next), e);
    const std::size_t last = next.terms().size() - 1;
    if (size(next, last) < 2 * options.least_amplitude * e.step()) continue;
    if (p_value(m, next, last) * scanned_hypotheses > options.alpha) continue;
    if (const double here = bayes(next, e); here > value) value = here, best = std::move(next);
  }
  if (!best) return;
  m = std::move(*best);
  prune(m, e);
}

}  // namespace

Selection select(const Evidence& e, const SelectOptions& options) {
  const Search search(e, options);
  Explanation model(e);
  while (model.terms().size() < options.most_terms) {
    std::optional<Explanation> next = search.better(model);
    if (!next) break;
    model = std::move(*next);
  }
  prune(model, e);
  add_remainder(model, e, options);
  Selection s{std::move(model), {}, {}};
  const double all = (e.measured - e.reference).square().mean();
  for (std::size_t i = 0; i < s.model.terms().size(); ++i) {
    const Explanation without = without_term(s.model, i);
    s.p_values.push_back(p_value(without, s.model, i));
    if (!s.model.terms()[i].named()) continue;
    const auto left = [&](const Explanation& m) {
      return (e.measured - e.reference - m.addition()).square().mean();
    };
    const double removed = left(without) - left(s.model);
    const double chosen = without.gain(s.model.terms()[i].columns);
    for (const Term& other : search.named()) {
      if (has(s.model, other.effect) || without.gain(other.columns) < 0.5 * chosen) continue;
      Explanation swapped = with_term(without, other);
      const double loss = bayes(s.model, e) - bayes(swapped, e);
      const double part = removed > 0 ? (left(without) - left(swapped)) / removed : 0;
      if (loss < cannot_be_told || (part > nearly_as_good && removed > 0.01 * all))
        s.alternatives.push_back({i, other.effect, loss});
    }
  }
  return s;
}

}  // namespace qerr
