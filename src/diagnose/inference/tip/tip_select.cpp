#include "diagnose/inference/tip/tip_select.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "diagnose/inference/tip/tip_alternatives.hpp"
#include "diagnose/inference/tip/tip_candidates.hpp"
#include "diagnose/inference/tip/tip_weight.hpp"

namespace qerr {

namespace {

constexpr int most_tip_fits = 6;

struct TipStep {
  TipTerm term;
  Eigen::VectorXd theta;  // of the term
  double log_likelihood = 0, cost = 0, correlated = 1;
};

std::optional<TipStep> next_step(const TipModel& model, const TipSelectOptions& options) {
  std::vector<TipTerm> all = tip_candidates(model);
  std::vector<std::pair<double, std::size_t>> passing;
  std::vector<Eigen::MatrixXd> columns;
  for (std::size_t i = 0; i < all.size(); ++i) {
    columns.push_back(model.columns(all[i]));
    const double gain = gain_of(model.solution(), model.beyond({}, columns.back()));
    if (gain > 4) passing.emplace_back(gain, i);
  }
  std::sort(passing.rbegin(), passing.rend());
  if (passing.size() > most_tip_fits) passing.resize(most_tip_fits);
  std::optional<TipStep> best;
  for (const auto& [gain, i] : passing) {
    const Eigen::Index size = columns[i].cols();
    const TipSolution s = model.trial({}, columns[i]);
    const Eigen::VectorXd theta = s.theta.tail(size);
    if (signal_to_noise(s, model.beyond({}, columns[i]), theta) <
        options.least_amplitude * required_signal_to_noise(all[i]))
      continue;
    // Counts are lost in whole numbers.
    if (all[i].term.whole && std::abs(theta[0]) < 0.7) continue;
    const double correlated = variance_inflation(model, s, columns[i]);
    const double gained = (s.log_likelihood - model.solution().log_likelihood) / correlated;
    const double cost = price(model, size) + penalty(model, all[i]);
    if (gained < cost + better_by) continue;
    const bool scanned = !all[i].kinematic() && (!all[i].term.named() || all[i].term.step);
    const double tests = static_cast<double>(all.size()) * (scanned ? scanned_at_tip : 1);
    if (p_value(gained, size) * tests > options.alpha) continue;
    // Correlated rows reduce the difference between two candidates, too.
    if (best && (s.log_likelihood - best->log_likelihood) / std::min(correlated, best->correlated) <
                    cost - best->cost)
      continue;
    best = TipStep{std::move(all[i]), theta, s.log_likelihood, cost, correlated};
  }
  return best;
}

/// Maximizes the likelihood over a term's order or time constant.
void reshape(TipModel& model, std::size_t term) {
  TipTerm best = model.terms()[term];
  if (!best.term.reshaped) return;
  const Evidence own = corrected_evidence(model.evidence(), model.estimate(), best.where);
  TipSolution solution = model.solution();
  bool moved = false;
  for (double step = 0.5 * best.term.half_width; step > 0.02 * best.term.half_width; step /= 2)
    for (const double by : {-step, step})
      for (int i = 0; i < 4; ++i) {
        TipTerm next = best;
        next.term = best.term.reshaped(own, best.term, best.term.shape + by);
        if (!(next.term.shape > 0)) break;
        const TipSolution s = model.trial({term}, model.columns(next));
        if (s.log_likelihood <= solution.log_likelihood + 1e-3) break;
        best = std::move(next);
        solution = s;
        moved = true;
      }
  if (!moved) return;
  const Eigen::VectorXd theta = solution.theta.tail(best.size());
  model.exchange(term, std::move(best), theta);
  model.fit();
}

double value_of(const TipModel& m) { return m.value(m.solution(), m.size()); }

/// Backward elimination of terms, the least significant first, until none is left.
void prune(TipModel& model) {
  for (;;) {
    std::optional<std::size_t> least;
    double lowest = better_by;
    for (std::size_t i = 0; i < model.terms().size(); ++i) {
      const double lost = model.solution().log_likelihood - model.trial({i}, {}).log_likelihood;
      const double worth = lost / variance_inflation(model, i) - price(model, model.terms()[i].size());
      if (worth < lowest) lowest = worth, least = i;
    }
    if (!least) return;
    model.remove(*least);
    model.fit();
  }
}

/// Forward selection. Each step raises the model's value, but may remove as many terms as it adds: a count
/// ends it.
TipModel grown(TipModel model, const TipSelectOptions& options) {
  for (std::size_t i = 0; i < 2 * options.most_terms && model.terms().size() < options.most_terms; ++i) {
    std::optional<TipStep> step = next_step(model, options);
    if (!step) break;
    TipModel next = model;
    next.add(std::move(step->term), step->theta);
    next.fit();
    reshape(next, next.terms().size() - 1);
    prune(next);
    if (!(value_of(next) >= value_of(model) + 0.5 * better_by)) break;
    model = std::move(next);
  }
  return model;
}

/// Backward elimination from all dimensions: with errors in many of them, no single one may be significant
/// alone.
TipModel with_all_dimensions(TipModel model) {
  for (TipTerm& t : tip_terms(model.evidence(), model.estimate())) {
    if (!t.kinematic() || chosen(model, t)) continue;
    // Linearly dependent on the others.
    if (model.beyond({}, model.columns(t)).isZero(0)) continue;
    const Eigen::VectorXd none = Eigen::VectorXd::Zero(t.size());  // a tilt may have two directions
    model.add(std::move(t), none);
    model.fit();
  }
  prune(model);
  return model;
}

TipModel best_model(TipModel start, const TipSelectOptions& options) {
  TipModel model = grown(std::move(start), options);
  const auto dimensions = std::count_if(model.terms().begin(), model.terms().end(),
                                        [](const TipTerm& t) { return t.kinematic() && t.term.named(); });
  if (dimensions < 3) return model;
  TipModel other = with_all_dimensions(model);
  return value_of(other) > value_of(model) + better_by ? std::move(other) : std::move(model);
}

/// Whether unknown frames are significant beside a model without them.
bool needs(UnknownFrames frames, const TipModel& model, const TipSelectOptions& options) {
  Eigen::MatrixXd columns = model.columns({TipTerm::Kind::tool, {}, 0});
  if (frames == UnknownFrames::all) {
    columns.conservativeResize(Eigen::NoChange, 9);
    columns.rightCols<6>() = model.columns({TipTerm::Kind::base, {}, 0});
  }
  const TipSolution with = model.trial({}, columns);
  const Eigen::Index more = with.rank - model.solution().rank;
  if (more <= 0) return false;
  const double gained =
      (with.log_likelihood - model.solution().log_likelihood) / variance_inflation(model, with, columns);
  return gained > price(model, more) + unnamed_penalty && p_value(gained, more) < options.alpha &&
         signal_to_noise(with, model.beyond({}, columns), with.theta.tail(columns.cols())) >
             2.5 * options.least_amplitude;
}

/// A model's value, with what free frames and terms cost beyond their coefficients.
double value_with_penalties(const TipModel& m) {
  const Eigen::Index free = m.trial({}, {}).rank - m.size();
  double cost = m.frames() == UnknownFrames::none     ? 0
                : m.frames() == UnknownFrames::target ? unnamed_penalty
                                                      : 2 * unnamed_penalty;
  for (const TipTerm& t : m.terms()) cost += penalty(m, t);
  return m.value(m.solution(), m.size() + free) - cost;
}

}  // namespace

TipSelection select_tip(const OperationalModel& model, const TipEvidence& e, std::uint64_t seed,
                        const TipSelectOptions& options) {
  const TipModel ideal(model, e, UnknownFrames::none, seed);
  TipModel found = best_model(ideal, options);
  const TipModel known = found;
  for (const UnknownFrames frames : {UnknownFrames::target, UnknownFrames::all}) {
    // Many terms together may imitate a frame.
    if (!needs(frames, ideal, options) && !needs(frames, known, options)) continue;
    TipModel framed = best_model(TipModel(model, e, frames, seed), options);
    if (value_with_penalties(framed) > value_with_penalties(found)) found = std::move(framed);
  }
  TipSelection s{std::move(found), {}, {}};
  find_tip_alternatives(model, s);
  for (std::size_t i = 0; i < s.model.terms().size(); ++i) {
    const TipTerm& t = s.model.terms()[i];
    const double gained = s.model.solution().log_likelihood - s.model.trial({i}, {}).log_likelihood;
    s.p_values.push_back(p_value(gained / variance_inflation(s.model, i), t.size()));
  }
  return s;
}

}  // namespace qerr
