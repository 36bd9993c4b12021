#include "select.hpp"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <numbers>

namespace qerr {

namespace {

constexpr int tried_in_full = 6;
constexpr int most_orders = 2000;

/// Candidate terms that depend on a scan of the present scores: the most likely step, the strongest order.
std::vector<Term> scanned_terms(const Evidence& e, const Explanation& model) {
  std::vector<Term> terms;
  const IntervalLikelihood& l = model.plain();
  if (e.ordered) {
    // A step at k adds the scores behind it; what a constant would take is left out of account.
    const double all = l.score.sum(), weight = l.curvature.sum();
    double behind = 0, weight_behind = 0, best = 0;
    Eigen::Index at = 0;
    for (Eigen::Index k = e.rows(); k-- > 8;) {
      behind += l.score[k];
      weight_behind += l.curvature[k];
      if (k + 8 > e.rows()) continue;
      const double part = weight_behind / weight, information = weight_behind * (1 - part);
      const double gain = information > 0 ? std::pow(behind - part * all, 2) / information : 0;
      if (gain > best) best = gain, at = k;
    }
    if (at > 0) terms.push_back(step_term(e, e.time[at]));
  }
  return terms;
}

/// The strongest free order of the encoder's shaft, over what the range of motion resolves.
Term strongest_order(const Evidence& e, const Explanation& model) {
  const IntervalLikelihood& l = model.plain();
  const double range = e.path.maxCoeff() - e.path.minCoeff();
  const double spacing =
      2 * std::numbers::pi / std::max(range, 1e-12) / 4;  // [periods per rad of joint] * 2 pi
  const Eigen::Index stride = std::max<Eigen::Index>(1, e.rows() / 8192);
  const auto power = [&](double order) {
    double sine = 0, cosine = 0;
    for (Eigen::Index k = 0; k < e.rows(); k += stride) {
      const double angle = order * e.path[k];
      sine += l.score[k] * std::sin(angle);
      cosine += l.score[k] * std::cos(angle);
    }
    return sine * sine + cosine * cosine;
  };
  double best = 0, best_order = 0;
  for (int i = 2; i < most_orders; ++i) {
    const double order = i * spacing;
    if (order * e.step() > 1.5) break;  // a period of four counts
    const double here = power(order);
    if (here > best) best = here, best_order = order;
  }
  for (double step = spacing / 2; step > spacing / 200; step /= 2)
    for (const double order : {best_order - step, best_order + step})
      if (const double here = power(order); here > best) best = here, best_order = order;
  Term t = periodic_term(e, "transmission_error", best_order, false);
  t.named = false;
  return t;
}

double bayes(const Explanation& m, const Evidence& e) {
  Eigen::Index count = 0;
  for (const Term& t : m.terms()) count += t.size();
  return m.log_likelihood() - 0.5 * static_cast<double>(count) * std::log(static_cast<double>(e.rows()));
}

double rms(const Eigen::ArrayXd& x) { return std::sqrt((x - x.mean()).square().mean() + 1e-300); }

double amplitude(const Explanation& m, std::size_t term) {
  const Eigen::ArrayXd added = (m.terms()[term].columns.matrix() * m.coefficients(term)).array();
  return m.terms()[term].effect.type == "offset" ? std::abs(added.mean()) : rms(added);
}

/// Of a model with a term against the one without it: the likelihood ratio, less what correlated errors make
/// of it.
double p_value(const Explanation& without, const Explanation& with, std::size_t term) {
  const Term& t = with.terms()[term];
  const double inflation = with.inflation(t.columns);
  const double ratio = 2 * (with.log_likelihood() - without.log_likelihood()) / inflation;
  return ratio > 0 ? cdf(complement(boost::math::chi_squared(static_cast<double>(t.size())), ratio)) : 1;
}

bool same(const Effect& a, const Effect& b) {
  return a.type == b.type && a.choices == b.choices && a.numbers.count("order") == b.numbers.count("order") &&
         a.number("order") == b.number("order") && a.number("time_constant") == b.number("time_constant") &&
         a.number("time") == b.number("time");
}

}  // namespace

Selection select(const Evidence& e, const SelectOptions& options) {
  const std::vector<Term> named = named_terms(e);
  Explanation model(e);
  while (model.terms().size() < options.most_terms) {
    std::vector<Term> candidates = named;
    for (Term& t : scanned_terms(e, model)) candidates.push_back(std::move(t));
    candidates.push_back(strongest_order(e, model));
    const auto tests = [&](const Term& t) {
      return static_cast<double>(named.size()) *
             (t.named && t.effect.type != "missed_counts" ? 1 : most_orders);
    };
    std::vector<std::pair<double, std::size_t>> passing;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const double gain = model.gain(candidates[i].columns);
      if (gain > 8) passing.emplace_back(gain, i);
    }
    std::sort(passing.rbegin(), passing.rend());
    if (passing.size() > tried_in_full) passing.resize(tried_in_full);
    std::optional<Explanation> best;
    double best_value = bayes(model, e);
    for (const auto& [gain, i] : passing) {
      Explanation next = model;
      next.add(candidates[i]);
      next.fit();
      if (amplitude(next, next.terms().size() - 1) <
          (candidates[i].named ? 1 : 2) * options.least_amplitude * e.step())
        continue;
      // What has no name must be clearly better than what has one.
      const double value = bayes(next, e) - (candidates[i].named ? 0 : 10);
      if (value < best_value + 3) continue;
      if (p_value(model, next, next.terms().size() - 1) * tests(candidates[i]) > options.alpha) continue;
      best_value = value;
      best = std::move(next);
    }
    if (!best) break;
    model = std::move(*best);
  }
  Selection s{std::move(model), {}, {}};
  for (std::size_t i = s.model.terms().size(); i-- > 0;) {
    Explanation without = s.model;
    without.remove(i);
    without.fit();
    if (bayes(without, e) > bayes(s.model, e) - 3) s.model = std::move(without);
  }
  for (std::size_t i = 0; i < s.model.terms().size(); ++i) {
    Explanation without = s.model;
    without.remove(i);
    without.fit();
    s.p_values.push_back(p_value(without, s.model, i));
    for (const Term& other : named) {
      bool present = false;
      for (const Term& t : s.model.terms()) present |= same(t.effect, other.effect);
      if (present) continue;
      Explanation swapped = without;
      swapped.add(other);
      swapped.fit();
      const double loss = bayes(s.model, e) - bayes(swapped, e);
      if (loss < 6) s.alternatives.push_back({i, other.effect, loss});
    }
  }
  return s;
}

}  // namespace qerr
