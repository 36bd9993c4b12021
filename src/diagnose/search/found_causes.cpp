#include "diagnose/search/found_causes.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/probability.hpp"
#include "core/statistics.hpp"
#include "diagnose/search/visible_effects.hpp"

namespace qerr {

namespace {

/// Part of what a term explains that another one must reach to be its alternative: real errors differ from
/// the textbook's shapes by some percent.
constexpr double alternative_share = 0.92;

/// Rise of the criterion up to which two terms cannot be told apart: the 99.95 % quantile of chi-squared with
/// one degree of freedom.
constexpr double indistinguishable = 12.1;

/// Whether a term is of the same effect and order as another.
bool same_term_type(const Term& a, const Term& b) {
  return a.effect.type == b.effect.type && a.effect.number_or("order", 0) == b.effect.number_or("order", 0);
}

/// Whether a candidate can stand in the place of a chosen term: of another effect, of no family of the other
/// chosen ones, and, where it is an order, of half a period or more: less would stand in for any curve.
bool may_replace(const ErrorModel& m, const Choice& choice, std::size_t i, std::size_t candidate) {
  const Candidate& c = m.candidate(candidate);
  const std::size_t replaced = choice.chosen[i];
  if (!c.term.named() || same_term_type(c.term, m.term(replaced)) || m.periods(candidate) < distinct_periods)
    return false;
  return std::none_of(choice.chosen.begin(), choice.chosen.end(),
                      [&](std::size_t g) { return g != replaced && m.candidate(g).family == c.family; });
}

/// Named terms that could replace a chosen one: the criterion hardly rises, or what is lost is a small part
/// of what the term explains.
void find_replacements(const ErrorModel& m, const Choice& choice, std::size_t i, FoundCauses& result) {
  LinearModel::Set other = choice.chosen;
  const bool complete = m.is_complete(choice.chosen);
  const double lost = m.lost_without(choice, i);
  for (std::size_t g = 0; g < m.candidates().size(); ++g) {
    if (!may_replace(m, choice, i, g)) continue;
    other[i] = g;
    const LinearModel::Fit f = m.fit(other);
    if (!m.possible(other, f)) continue;
    const double left = f.rss - choice.fit.rss, least = m.group(g).least_gain;
    const bool likely = left / m.scale(choice) < indistinguishable;
    // Where everything is explained, a small part that the other leaves of a small error is evidence
    // against it; of a large error, it may be the idealization of its shape.
    const bool near = left < (1 - alternative_share) * lost &&
                      (!complete || (left < 2 * least && lost > 2 * least / (1 - alternative_share)));
    if (likely || near) result.replacements.push_back({result.chosen.size(), m.term(g).effect});
  }
}

ChosenTerm chosen_term(const ErrorModel& m, const Choice& choice, std::size_t i) {
  const double lost = m.lost_without(choice, i), independent = m.rows() / choice.correlation;
  const double free = std::max(1.0, independent - static_cast<double>(choice.fit.coefficients.size()));
  ChosenTerm c{m.candidate(choice.chosen[i]), m.coefficients(choice.chosen, choice.fit, i)};
  const auto d = static_cast<double>(c.candidate.term.size());
  c.p_value = std::min(1.0, fisher_f_tail(lost / d / m.scale(choice), d, free) * c.candidate.alternatives *
                                static_cast<double>(m.candidates().size()));
  c.lost = lost / m.weight().sum();
  const Eigen::ArrayXd added = addition(c.candidate.term, c.coefficients);
  c.rms = c.candidate.term.constant ? std::abs(added.mean()) : standard_deviation(added);
  return c;
}

}  // namespace

void distinguish_steps(const ErrorModel& m, Choice& choice) {
  for (std::size_t i = 0; i < choice.chosen.size(); ++i) {
    const std::size_t whole = choice.chosen[i];
    if (!m.term(whole).whole) continue;
    const double counts = m.coefficients(choice.chosen, choice.fit, i)[0];
    const double error =
        std::abs(counts) * std::sqrt(m.scale(choice) / std::max(m.lost_without(choice, i), 1e-300));
    // Edges that are displaced by up to a tenth of a count, and the motion, bias it by 0.01 at the most (60
    // random records); a slip is anywhere.
    if (std::abs(counts - std::round(counts)) < 4 * error + 0.02 && std::round(counts) != 0) continue;
    for (std::size_t g = 0; g < m.candidates().size(); ++g)
      if (m.candidate(g).family == m.candidate(whole).family && m.term(g).step && !m.term(g).named()) {
        choice.chosen[i] = g;
        break;
      }
  }
  choice.fit = m.fit(choice.chosen);
  choice.residual = m.residual(choice.chosen, choice.fit);
}

FoundCauses found_causes(const ErrorModel& m, const Choice& choice) {
  FoundCauses result;
  result.samples_per_reading = choice.correlation;
  result.explained = (m.fit({}).rss - choice.fit.rss) / m.weight().sum();
  result.visible = visible_effects(m, choice);
  std::vector<std::size_t> order(choice.chosen.size());
  std::vector<double> left;
  for (std::size_t i = 0; i < order.size(); ++i) {
    order[i] = i;
    left.push_back(m.fit({choice.chosen[i]}).rss);
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return left[a] < left[b]; });
  for (const std::size_t i : order) {
    if (m.term(choice.chosen[i]).named()) find_replacements(m, choice, i, result);
    result.chosen.push_back(chosen_term(m, choice, i));
  }
  return result;
}

}  // namespace qerr
