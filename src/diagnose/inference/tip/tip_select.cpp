#include "diagnose/inference/tip/tip_select.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/random.hpp"
#include "core/solve.hpp"
#include "diagnose/inference/tip/tip_remainder.hpp"
#include "diagnose/inference/tip/tip_weight.hpp"
#include "diagnose/search/peaks.hpp"

namespace qerr {

namespace {

/// What a unit of each encoder's reading does for the likelihood: encoders x rows.
Eigen::MatrixXd encoder_scores(const TipModel& model) {
  const TipEvidence& e = model.evidence();
  const auto coordinates = static_cast<Eigen::Index>(e.axes.size());
  const Eigen::VectorXd pull = model.solution().weight.cwiseProduct(model.solution().residual);
  Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(e.encoders.size()), e.rows());
  for (std::size_t i = 0; i < e.encoders.size(); ++i) {
    if (!e.judged(i)) continue;
    TipTerm unit{TipTerm::Kind::encoder, {}, i};
    unit.term.columns = Eigen::ArrayXXd::Ones(e.rows(), 1);
    const Eigen::MatrixXd column = model.columns(unit);
    for (Eigen::Index k = 0; k < e.rows(); ++k)
      scores(static_cast<Eigen::Index>(i), k) =
          column.col(0).segment(k * coordinates, coordinates).dot(pull.segment(k * coordinates, coordinates));
  }
  return scores;
}

/// The step of lost counts with the largest score, orthogonal to a constant.
std::optional<Term> strongest_tip_step(const Evidence& e, const Eigen::VectorXd& score) {
  const double all = score.sum();
  const auto rows = static_cast<double>(score.size());
  double after = 0, best = 0;
  Eigen::Index at = 0;
  for (Eigen::Index k = score.size(); k-- > 8;) {
    after += score[k];
    if (k + 8 > score.size()) continue;
    const double part = static_cast<double>(score.size() - k) / rows;
    const double gain = std::pow(after - part * all, 2) / (part * (1 - part));
    if (gain > best) best = gain, at = k;
  }
  if (at == 0) return std::nullopt;
  return step_term(e, 0.5 * (e.time[at] + e.time[at - 1]));
}

/// The strongest free order of the joint, over what its range of motion resolves.
std::optional<Term> strongest_tip_order(const Evidence& e, const Eigen::VectorXd& score) {
  const double range = e.path.maxCoeff() - e.path.minCoeff();
  if (range < 20 * e.step()) return std::nullopt;
  const double spacing = std::numbers::pi / range;
  const auto some = Eigen::seq(0, Eigen::last, std::max<Eigen::Index>(1, e.rows() / 2048));
  const Eigen::ArrayXd angle = e.path(some) - e.path.minCoeff(), weight = score(some).array();
  const auto last =
      std::min<Eigen::Index>(scanned_at_tip - 1, static_cast<Eigen::Index>(1.5 / (spacing * e.step())));
  // Every other one of half the spacing. Its errors are below 3 % of the largest power: those that may be the
  // largest are summed.
  const std::vector<float> powers = periodogram(weight, angle, spacing / 2, 0, 2 * last);
  float least = 0;
  for (auto i = std::size_t{4}; i < powers.size(); i += 2) least = std::max(least, powers[i]);
  least -= 0.06F * *std::max_element(powers.begin(), powers.end());
  double best = 0, best_order = 0;
  for (auto i = std::size_t{4}; i < powers.size(); i += 2)
    if (const double order = static_cast<double>(i) * spacing / 2; powers[i] >= least)
      if (const double here = power_at(weight, angle, order); here > best) best = here, best_order = order;
  for (double step = spacing / 2; step > spacing / 100; step /= 2)
    for (const double order : {best_order - step, best_order + step})
      if (const double here = power_at(weight, angle, order); here > best) best = here, best_order = order;
  return free_order_term(e, best_order);
}

bool same(const TipTerm& a, const TipTerm& b) {
  const Effect &x = a.term.effect, &y = b.term.effect;
  return a.kind == b.kind && a.where == b.where && a.directions == b.directions && x.type == y.type &&
         x.choices == y.choices && x.number_or("order", 0) == y.number_or("order", 0) &&
         x.numbers.contains("time_constant") == y.numbers.contains("time_constant") &&  // which is fitted
         x.number_or("time", 0) == y.number_or("time", 0) && (!a.of_record() || a.size() == b.size());
}

}  // namespace

bool chosen(const TipModel& model, const TipTerm& t) {
  return std::any_of(model.terms().begin(), model.terms().end(),
                     [&](const TipTerm& other) { return same(other, t); });
}

std::vector<TipTerm> tip_candidates(const TipModel& model) {
  const TipEvidence& e = model.evidence();
  std::vector<TipTerm> all = tip_terms(e, model.estimate());
  for (TipTerm& t : tilt_terms(model.nominal())) all.push_back(std::move(t));
  constexpr Eigen::Index fewest_of_step = 100, fewest_of_order = 500;  // conventions
  if (e.ordered && e.rows() >= fewest_of_step) {
    const Eigen::MatrixXd scores = encoder_scores(model);
    for (std::size_t i = 0; i < e.encoders.size(); ++i) {
      if (!e.judged(i)) continue;
      const Evidence own = corrected_evidence(e, model.estimate(), i);
      const Eigen::VectorXd score = scores.row(static_cast<Eigen::Index>(i));
      if (auto step = strongest_tip_step(own, score))
        all.push_back({TipTerm::Kind::encoder, std::move(*step), i});
      if (e.rows() < fewest_of_order) continue;
      if (auto order = strongest_tip_order(own, score))
        all.push_back({TipTerm::Kind::encoder, std::move(*order), i});
    }
  }
  std::erase_if(all, [&](const TipTerm& t) { return chosen(model, t); });
  return all;
}

namespace {

constexpr int most_tip_fits = 6;

/// Whether a machine can have an error of this size: no dimension is wrong by more than the arm's reach, and
/// no zero by more than half a turn; a play has a width, whichever side the encoder is on. Beside a joint
/// that rests only a difference of such errors shows.
bool is_possible(const TipModel& m, const TipTerm& t, const Eigen::VectorXd& coefficients) {
  if ((t.term.hysteresis || t.term.of_reference) && coefficients[0] < 0) return false;
  const Eigen::MatrixXd& tip = m.evidence().tip;
  double reach = m.nominal().tip_offset.translation().norm() +
                 (tip.rowwise().maxCoeff() - tip.rowwise().minCoeff()).norm();
  for (const ChainJoint& joint : m.nominal().joints) reach += joint.origin.translation().norm();
  const bool turns = t.kind == TipTerm::Kind::encoder && !m.evidence().encoders[t.where].prismatic;
  if (t.kind == TipTerm::Kind::geometry || (t.term.constant && !turns)) return coefficients.norm() <= reach;
  return !t.term.constant || coefficients.norm() <= std::numbers::pi;
}

bool is_possible(const TipModel& m) {
  for (std::size_t i = 0; i < m.terms().size(); ++i)
    if (!is_possible(m, m.terms()[i], m.coefficients(i))) return false;
  return true;
}

struct TipStep {
  TipTerm term;
  Eigen::VectorXd theta;  // of the term
  double log_likelihood = 0, cost = 0, correlated = 1;
};

std::optional<TipStep> next_step(const TipModel& model, std::vector<TipTerm> all,
                                 const TipSelectOptions& options) {
  std::vector<std::pair<double, std::size_t>> passing;
  std::vector<Eigen::MatrixXd> columns;
  for (std::size_t i = 0; i < all.size(); ++i) {
    columns.push_back(model.columns(all[i]));
    const double gain = model.gain(columns.back());
    if (gain > 4) passing.emplace_back(gain, i);
  }
  std::sort(passing.rbegin(), passing.rend());
  // Of many coefficients, displacements of the tracker gain more than what is simpler: both have their share.
  std::array<int, 2> fits{};
  std::erase_if(passing, [&](const auto& p) { return ++fits[all[p.second].of_record()] > most_tip_fits; });
  std::optional<TipStep> best;
  for (const auto& [gain, i] : passing) {
    const Eigen::Index size = columns[i].cols();
    const TipSolution s = model.trial({}, columns[i]);
    const Eigen::VectorXd theta = s.theta.tail(size);
    if (signal_to_noise(s, model.beyond(columns[i]), theta) <
        options.least_amplitude * required_signal_to_noise(all[i]))
      continue;
    if (!is_possible(model, all[i], theta)) continue;
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
  const Evidence own = best.of_record() ? model.evidence().encoders.front()
                                        : corrected_evidence(model.evidence(), model.estimate(), best.where);
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

std::vector<TipTerm> unchosen_tracker_terms(const TipModel& model) {
  std::vector<TipTerm> terms = tracker_terms(model);
  std::erase_if(terms, [&](const TipTerm& t) { return chosen(model, t); });
  return terms;
}

double value_of(const TipModel& m) { return m.value(m.solution(), m.size()); }

/// The log-likelihood that is lost without a term at the solution's weights: exact to second order.
double quadratic_loss(const TipModel& model, std::size_t term) {
  const Eigen::Index at = model.position(term), size = model.terms()[term].size();
  const Eigen::VectorXd theta = model.solution().theta.segment(at, size);
  const NormalInverse information(model.solution().covariance.block(at, at, size, size));
  return 0.5 * theta.dot(information.inverse * theta);
}

/// Backward elimination of terms, the least significant first, until none is left. Of many terms only those
/// are tried whose loss is least to second order.
void prune(TipModel& model) {
  constexpr std::size_t tried = 4;
  struct Removal {
    double worth;  // to second order
    std::size_t term;
    double correlated, cost;
  };
  bool fitted = true;
  for (;;) {
    std::vector<Removal> order;
    for (std::size_t i = 0; i < model.terms().size(); ++i) {
      const double correlated = variance_inflation(model, i), cost = price(model, model.terms()[i].size());
      order.push_back({quadratic_loss(model, i) / correlated - cost, i, correlated, cost});
    }
    std::sort(order.begin(), order.end(),
              [](const Removal& a, const Removal& b) { return a.worth < b.worth; });
    if (order.size() > tried) order.resize(tried);
    std::optional<std::size_t> least;
    double lowest = better_by;
    for (const Removal& r : order) {
      const double lost = model.solution().log_likelihood - model.trial({r.term}, {}).log_likelihood;
      const double worth = lost / r.correlated - r.cost;
      if (worth < lowest) lowest = worth, least = r.term;
    }
    if (!least && fitted) return;
    if (least) {
      model.remove(*least);
      model.refit();
    } else {
      model.fit();
    }
    fitted = !least;
  }
}

/// Forward selection. Each step raises the model's value, but may remove as many terms as it adds: a count
/// ends it.
TipModel grown(TipModel model, const TipSelectOptions& options) {
  for (std::size_t i = 0; i < 2 * options.most_terms && model.terms().size() < options.most_terms; ++i) {
    std::vector<TipTerm> all = tip_candidates(model);
    if (options.tracker)
      for (TipTerm& t : unchosen_tracker_terms(model)) all.push_back(std::move(t));
    std::optional<TipStep> step = next_step(model, std::move(all), options);
    if (!step) break;
    TipModel next = model;
    next.add(std::move(step->term), step->theta);
    next.fit();
    reshape(next, next.terms().size() - 1);
    prune(next);
    settle_knocks(next);
    if (!(value_of(next) >= value_of(model) + 0.5 * better_by) || !is_possible(next)) break;
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
    if (model.beyond(model.columns(t)).isZero(0)) continue;
    const Eigen::VectorXd none = Eigen::VectorXd::Zero(t.size());  // a tilt may have two directions
    model.add(std::move(t), none);
    model.refit();
  }
  model.fit();
  prune(model);
  return model;
}

TipModel best_model(TipModel start, const TipSelectOptions& options) {
  TipModel model = grown(std::move(start), options);
  const auto dimensions = std::count_if(model.terms().begin(), model.terms().end(),
                                        [](const TipTerm& t) { return t.kinematic() && t.term.named(); });
  if (dimensions < 3) return model;
  TipModel other = with_all_dimensions(model);
  const bool better = value_of(other) > value_of(model) + better_by && is_possible(other);
  return better ? std::move(other) : std::move(model);
}

/// Whether unknown frames are significant beside a model without them.
bool needs(UnknownFrames frames, const TipModel& model, const TipSelectOptions& options) {
  Eigen::MatrixXd columns(model.entries().size(), frames.size());
  if (frames.base) columns.leftCols<6>() = model.columns({TipTerm::Kind::base, {}, 0});
  if (frames.target) columns.rightCols<3>() = model.columns({TipTerm::Kind::tool, {}, 0});
  const TipSolution with = model.trial({}, columns);
  const Eigen::Index more = with.rank - model.solution().rank;
  if (more <= 0) return false;
  const double gained =
      (with.log_likelihood - model.solution().log_likelihood) / variance_inflation(model, with, columns);
  return gained > price(model, more) + unnamed_penalty && p_value(gained, more) < options.alpha &&
         signal_to_noise(with, model.beyond(columns), with.theta.tail(columns.cols())) >
             2.5 * options.least_amplitude;
}

/// A model's value, with what free frames and terms cost beyond their coefficients.
double value_with_penalties(const TipModel& m) {
  const Eigen::Index free = m.trial({}, {}).rank - m.size();
  // A frame displaces the first joint in all directions: of two that leave the same it is the simpler cause.
  double cost = (m.frames().target ? unnamed_penalty : 0) + (m.frames().base ? 0.5 * unnamed_penalty : 0);
  for (const TipTerm& t : m.terms()) cost += penalty(m, t);
  return m.value(m.solution(), m.size() + free) - cost;
}

/// Whether the tracker's frame is turned across the axis of the first joint. If not, a displaced first joint
/// with another zero is the simpler cause of the same.
bool is_turned(const TipModel& m, double alpha) {
  const ChainJoint& first = m.nominal().joints.front();
  const Eigen::AngleAxisd turn((m.estimate().base * m.nominal().tracker.inverse()).linear());
  const Eigen::Vector3d axis =
      (m.nominal().tracker.linear() * first.origin.linear() * first.axis).normalized();
  Eigen::MatrixXd across = Eigen::MatrixXd::Identity(3, 3);
  if (!first.prismatic) across -= axis * axis.transpose();
  const Eigen::VectorXd rotation = across * (turn.angle() * turn.axis());
  const Eigen::MatrixXd columns = m.all_columns().middleCols(3, 3);
  const double inflation = TipModel::variance_inflation(m.solution(), columns,
                                                        static_cast<Eigen::Index>(m.evidence().axes.size()));
  const NormalInverse information(inflation * across * m.solution().covariance.block(3, 3, 3, 3) * across);
  return p_value(0.5 * rotation.dot(information.inverse * rotation), information.rank) < alpha;
}

/// The model without dimensions, tilts and zeros: many of them together imitate a frame.
TipModel without_dimensions(TipModel m) {
  for (std::size_t i = m.terms().size(); i-- > 0;)
    if (m.terms()[i].kinematic()) m.remove(i);
  m.fit();
  return m;
}

/// What some rows of a record say of unknown frames.
struct SeenFrames {
  UnknownFrames needed;
  std::vector<UnknownFrames> needless;  ///< also for all rows
};

/// Frames that were tried, and what they bring beyond the best model before.
struct FrameTrial {
  UnknownFrames frames;
  double log_likelihood = 0, value = 0;
};

struct FramedModel {
  TipModel model;
  std::vector<FrameTrial> trials;
};

/// Whether what a model leaves is no more than what neighbouring rows differ by: nothing is left to explain.
bool leaves_noise(const TipModel& m) {
  constexpr double complete = 1.3;  // as of an encoder's model
  return m.solution().sigma <= complete * m.evidence().noise;
}

/// The best model with or without unknown frames.
/// @param plain  without causes and frames
FramedModel best_framed(const OperationalModel& model, const TipModel& plain, const SeenFrames& seen,
                        const TipSelectOptions& options) {
  const TipEvidence& e = plain.evidence();
  const std::uint64_t seed = plain.seed();
  const TipModel ideal = seen.needed.size() == 0 ? plain : TipModel(model, e, seen.needed, seed);
  FramedModel best{best_model(ideal, options), {}};
  TipModel& found = best.model;
  const TipModel known = found, bare = without_dimensions(found);
  std::optional<TipModel> not_turned;
  for (const UnknownFrames frames :
       {UnknownFrames{.target = true}, UnknownFrames{.base = true}, UnknownFrames{true, true}}) {
    if (frames.size() <= seen.needed.size()) continue;
    // A search that ends too early may begin better with a frame.
    if (leaves_noise(known) && std::count(seen.needless.begin(), seen.needless.end(), frames) > 0) continue;
    // What moves the tracker has a mean, too.
    const bool in_time = std::any_of(known.terms().begin(), known.terms().end(),
                                     [](const TipTerm& t) { return t.of_record(); });
    if ((in_time || !needs(frames, ideal, options)) && !needs(frames, known, options) &&
        !needs(frames, bare, options))
      continue;
    TipModel framed = best_model(TipModel(model, e, frames, seed), options);
    const double value = value_with_penalties(framed) - value_with_penalties(found);
    best.trials.push_back(
        {frames, framed.solution().log_likelihood - found.solution().log_likelihood, value});
    if (frames.base && !frames.target && !is_turned(framed, 0.01 * options.alpha)) {
      not_turned = std::move(framed);
      continue;
    }
    if (!(value > 0)) continue;
    // A displaced target beside a frame that is not turned is worth more than the frame alone, or is none.
    const bool alone = not_turned && value_with_penalties(*not_turned) >= value_with_penalties(framed);
    found = alone ? *not_turned : std::move(framed);
  }
  return best;
}

/// Which frames a record needs is seen in some of its rows, if it is seen at all. Those that were tried there
/// are needless where the likelihood of all rows, in proportion to that of these, would not be worth them.
SeenFrames frames_of_some_rows(const OperationalModel& model, const TipEvidence& e, std::uint64_t seed,
                               const TipSelectOptions& options) {
  constexpr Eigen::Index enough = 600;
  if (e.rows() < 2 * enough) return {};
  std::vector<Eigen::Index> rows;
  for (Eigen::Index k = 0; k < e.rows(); k += e.rows() / enough) rows.push_back(k);
  const TipEvidence some = with_rows(e, rows);
  const FramedModel best = best_framed(model, TipModel(model, some, {}, seed), {}, options);
  const double more = static_cast<double>(e.rows()) / static_cast<double>(some.rows()) - 1;
  SeenFrames seen{best.model.frames(), {}};
  for (const FrameTrial& t : best.trials) {
    if (t.frames.size() <= seen.needed.size()) continue;
    // They are compared with each other, too.
    if (t.value + more * t.log_likelihood > 0) return {seen.needed, {}};
    seen.needless.push_back(t.frames);
  }
  return seen;
}

/// Sum of squares that a model leaves beside a constant displacement, which is no matter of time [m^2].
double left_beside_constant(const TipModel& m, const std::optional<TipStep>& more) {
  const Eigen::MatrixXd constant = m.columns({TipTerm::Kind::base, {}, 0}).leftCols<3>();
  Eigen::MatrixXd columns(constant.rows(), 3 + (more ? more->theta.size() : 0));
  columns.leftCols<3>() = constant;
  if (more) columns.rightCols(more->theta.size()) = m.columns(more->term);
  return m.trial({}, columns).residual.squaredNorm();
}

/// The displacement of the tracker that alone explains most, and the sums of squares without and with it.
struct Displacement {
  std::optional<TipStep> step;
  double before = 0, after = 0;
};

Displacement displacement_alone(const TipModel& ideal, const TipSelectOptions& options) {
  Displacement d{next_step(ideal, tracker_terms(ideal), options)};
  if (!d.step) return d;
  d.before = left_beside_constant(ideal, {});
  d.after = left_beside_constant(ideal, d.step);
  return d;
}

/// Whether a displacement of the tracker in time explains what the causes leave, or alone half of what
/// several of them explain: these may imitate it.
bool may_be_displaced(const TipModel& found, const Displacement& alone, const TipSelectOptions& options) {
  constexpr Eigen::Index several = 3;  // coefficients: the simplest displacement has as many
  if (next_step(found, tracker_terms(found), options)) return true;
  const auto in_time = std::count_if(found.terms().begin(), found.terms().end(),
                                     [](const TipTerm& t) { return !t.kinematic(); });
  if (!alone.step || (in_time < 2 && found.size() + found.frames().size() < several)) return false;
  const double explained = alone.before - found.solution().residual.squaredNorm();
  return alone.before - alone.after > 0.5 * explained;
}

/// The value of a model among those of a record that may have a displaced tracker: many faults that together
/// imitate a tracker's are rarer than its one, and each step is at one of many rows. Several joints that lose
/// counts at the same instant are a coincidence.
double value_among_tracked(const TipModel& m) {
  const auto steps = std::count_if(m.terms().begin(), m.terms().end(), [](const TipTerm& t) {
    return t.term.step || (t.of_record() && t.kind != TipTerm::Kind::growth && t.where > 0);
  });
  return value_with_penalties(m) - better_by * static_cast<double>(m.terms().size()) -
         static_cast<double>(steps) * std::log(static_cast<double>(m.evidence().rows()));
}

bool is_displaced(const TipModel& m) {
  return std::any_of(m.terms().begin(), m.terms().end(), [](const TipTerm& t) { return t.of_record(); });
}

TipModel best_tracked(const OperationalModel& model, const TipEvidence& e, std::uint64_t seed,
                      TipSelectOptions options) {
  const TipModel plain(model, e, {}, seed);
  const Displacement alone = displacement_alone(plain, options);
  TipSelectOptions with_tracker = options;
  with_tracker.tracker = true;
  // Where a displacement leaves less than half, models without it are sought among those of few causes only:
  // many would imitate it.
  std::optional<TipModel> fresh;
  if (alone.step && alone.after < 0.5 * alone.before) {
    fresh = best_framed(model, plain, {}, with_tracker).model;
    if (is_displaced(*fresh)) options.most_terms = fresh->terms().size() + 2;
  }
  TipModel found = best_framed(model, plain, frames_of_some_rows(model, e, seed, options), options).model;
  if (!fresh && !may_be_displaced(found, alone, options)) return found;
  if (!fresh) fresh = best_framed(model, plain, {}, with_tracker).model;
  TipModel more = grown(found, with_tracker);
  for (TipModel* other : {&more, &*fresh})
    if (is_displaced(*other) && value_among_tracked(*other) > value_among_tracked(found))
      found = std::move(*other);
  return found;
}

}  // namespace

TipSelection select_tip(const OperationalModel& model, const TipEvidence& e, std::uint64_t seed,
                        const TipSelectOptions& options) {
  TipSelection s{best_tracked(model, e, seed, options), {}, {}};
  find_tip_alternatives(model, s);
  for (std::size_t i = 0; i < s.model.terms().size(); ++i) {
    const TipTerm& t = s.model.terms()[i];
    const double gained = s.model.solution().log_likelihood - s.model.trial({i}, {}).log_likelihood;
    s.p_values.push_back(p_value(gained / variance_inflation(s.model, i), t.size()));
  }
  return s;
}

namespace {

constexpr double as_good = 6;  // of log-likelihood

/// Evidence with random poses: terms that these cannot distinguish, no record can.
TipEvidence random_poses(const TipEvidence& e, const Chain& chain, std::uint64_t seed) {
  TipEvidence wide = e;
  const Eigen::Index rows = std::min<Eigen::Index>(100, e.rows());
  wide.tip.setZero(e.tip.rows(), rows);
  wide.joints.resize(e.joints.rows(), rows);
  for (Eigen::Index j = 0; j < wide.joints.rows(); ++j)
    for (Eigen::Index k = 0; k < rows; ++k) {
      const double u =
          unit_interval(random_bits(seed, static_cast<std::uint64_t>(k), static_cast<std::uint64_t>(j)));
      wide.joints(j, k) =
          (2 * u - 1) * (chain.independent[static_cast<std::size_t>(j)].prismatic() ? 0.5 : std::numbers::pi);
    }
  for (Evidence& own : wide.encoders)
    for (Eigen::ArrayXd* series : series_of(own))
      if (series->size() > 0) series->conservativeResize(rows);
  return wide;
}

TipTerm shortened(TipTerm t, Eigen::Index rows) {
  if (t.kind == TipTerm::Kind::encoder) t.term.columns = t.term.columns.topRows(rows).eval();
  return t;
}

/// Whether another term can replace a chosen one in every pose; both depend on the pose alone.
bool everywhere(const OperationalModel& model, const TipModel& fitted, std::size_t term,
                const TipTerm& other) {
  if (!fitted.terms()[term].kinematic() || !other.kinematic()) return false;
  const TipEvidence wide =
      random_poses(fitted.evidence(), model.chain, stream_seed(fitted.seed(), "tip poses"));
  TipModel poses(model, wide, {}, fitted.seed());
  const Eigen::MatrixXd target = poses.columns(shortened(fitted.terms()[term], wide.rows()));
  Eigen::MatrixXd rest = poses.columns(shortened(other, wide.rows()));
  const auto append = [&](const TipTerm& t) {
    rest.conservativeResize(Eigen::NoChange, rest.cols() + t.size());
    rest.rightCols(t.size()) = poses.columns(t);
  };
  for (std::size_t i = 0; i < fitted.terms().size(); ++i)
    if (i != term && fitted.terms()[i].kinematic()) append(shortened(fitted.terms()[i], wide.rows()));
  if (fitted.frames().base) append({TipTerm::Kind::base, {}, 0});
  if (fitted.frames().target) append({TipTerm::Kind::tool, {}, 0});
  const Eigen::VectorXd fit = least_norm_solution(rest, target);
  return (target - rest * fit).norm() < 1e-6 * target.norm();
}

}  // namespace

void find_tip_alternatives(const OperationalModel& model, TipSelection& s) {
  TipModel& m = s.model;
  for (int round = 0; round < 8; ++round) {
    s.alternatives.clear();
    const std::vector<TipTerm> others = tip_terms(m.evidence(), m.estimate());
    std::vector<Eigen::MatrixXd> columns;
    for (const TipTerm& t : others) columns.push_back(m.columns(t));
    bool exchanged = false;
    for (std::size_t i = 0; i < m.terms().size() && !exchanged; ++i) {
      const double correlated = variance_inflation(m, i);
      const TipSolution without = m.trial({i}, {});
      TipSolution at_weights = without;
      at_weights.weight = m.solution().weight;
      const TipModel::Projection of_others = m.projection({i});
      const double own = gain_of(at_weights, m.beyond(of_others, m.columns(i)));
      for (std::size_t o = 0; o < others.size(); ++o) {
        const TipTerm& other = others[o];
        if (chosen(m, other)) continue;
        if (gain_of(at_weights, m.beyond(of_others, columns[o])) < own - correlated * (2 * as_good + 20))
          continue;
        const TipSolution swapped = m.trial({i}, columns[o]);
        const Eigen::VectorXd theta = swapped.theta.tail(columns[o].cols());
        if (!is_possible(m, other, theta)) continue;
        const double loss = (m.solution().log_likelihood - swapped.log_likelihood) / correlated +
                            price(m, columns[o].cols()) - price(m, m.terms()[i].size()) + penalty(m, other) -
                            penalty(m, m.terms()[i]);
        if (loss < -better_by && round < 7) {
          m.exchange(i, other, theta);
          m.fit();
          exchanged = true;
          break;
        }
        if (loss < as_good && m.terms()[i].term.named()) s.alternatives.push_back({i, other, loss, false});
      }
    }
    if (!exchanged) break;
  }
  for (TipAlternative& a : s.alternatives) a.everywhere = everywhere(model, m, a.term, a.other);
}

}  // namespace qerr
