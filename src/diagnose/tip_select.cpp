#include "tip_select.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <numbers>
#include <optional>

#include "qerr/core/random.hpp"

namespace qerr {

namespace {

constexpr int tried_in_full = 6;
constexpr int most_orders = 600;
constexpr double better = 3;         // of log-likelihood, beyond Bayes' criterion, for one more term
constexpr double without_name = 10;  // what has no name must be clearly better than what has one
constexpr double as_good = 6;

/// What a unit of each encoder's reading does for the likelihood: encoders x rows.
Eigen::MatrixXd encoder_scores(const TipModel& model) {
  const TipEvidence& e = model.evidence();
  const auto coordinates = static_cast<Eigen::Index>(e.axes.size());
  const Eigen::VectorXd pull = model.solution().weight.cwiseProduct(model.solution().rest);
  Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(e.encoders.size()), e.rows());
  for (std::size_t i = 0; i < e.encoders.size(); ++i) {
    if (!e.judged(i)) continue;
    TipTerm unit{TipTerm::Way::encoder, {}, i, 0};
    unit.term.columns = Eigen::ArrayXXd::Ones(e.rows(), 1);
    const Eigen::MatrixXd column = model.columns(unit);
    for (Eigen::Index k = 0; k < e.rows(); ++k)
      scores(static_cast<Eigen::Index>(i), k) =
          column.col(0).segment(k * coordinates, coordinates).dot(pull.segment(k * coordinates, coordinates));
  }
  return scores;
}

/// The moment at which lost counts would explain most, what a constant takes left out of account.
std::optional<Term> likeliest_step(const Evidence& e, const Eigen::VectorXd& score) {
  const double all = score.sum();
  const auto rows = static_cast<double>(score.size());
  double behind = 0, best = 0;
  Eigen::Index at = 0;
  for (Eigen::Index k = score.size(); k-- > 8;) {
    behind += score[k];
    if (k + 8 > score.size()) continue;
    const double part = static_cast<double>(score.size() - k) / rows;
    const double gain = std::pow(behind - part * all, 2) / (part * (1 - part));
    if (gain > best) best = gain, at = k;
  }
  if (at == 0) return std::nullopt;
  return step_term(e, 0.5 * (e.time[at] + e.time[at - 1]));
}

/// The strongest free order of the joint, over what its range of motion resolves.
std::optional<Term> strongest_order(const Evidence& e, const Eigen::VectorXd& score) {
  const double range = e.path.maxCoeff() - e.path.minCoeff();
  if (range < 20 * e.step()) return std::nullopt;
  const double spacing = 2 * std::numbers::pi / range / 2;
  const Eigen::Index stride = std::max<Eigen::Index>(1, e.rows() / 2048);
  const auto power = [&](double order) {
    double sine = 0, cosine = 0;
    for (Eigen::Index k = 0; k < e.rows(); k += stride) {
      sine += score[k] * std::sin(order * e.path[k]);
      cosine += score[k] * std::cos(order * e.path[k]);
    }
    return sine * sine + cosine * cosine;
  };
  double best = 0, best_order = 0;
  for (int i = 2; i < most_orders && i * spacing * e.step() < 1.5; ++i)
    if (const double here = power(i * spacing); here > best) best = here, best_order = i * spacing;
  for (double step = spacing / 2; step > spacing / 100; step /= 2)
    for (const double order : {best_order - step, best_order + step})
      if (const double here = power(order); here > best) best = here, best_order = order;
  return free_order_term(e, best_order);
}

bool same(const TipTerm& a, const TipTerm& b) {
  const Effect &x = a.term.effect, &y = b.term.effect;
  return a.way == b.way && a.where == b.where && a.along == b.along && x.type == y.type &&
         x.choices == y.choices && x.number("order") == y.number("order") &&
         x.number("time_constant") == y.number("time_constant") && x.number("time") == y.number("time");
}

bool chosen(const TipModel& model, const TipTerm& t) {
  return std::any_of(model.terms().begin(), model.terms().end(),
                     [&](const TipTerm& other) { return same(other, t); });
}

/// What the model may be extended by: the catalogue, and what a scan of the present scores suggests.
std::vector<TipTerm> candidates(const TipModel& model, bool scanned) {
  const TipEvidence& e = model.evidence();
  std::vector<TipTerm> all = tip_terms(e, model.belief());
  if (scanned && e.ordered && e.rows() >= 500) {
    const Eigen::MatrixXd scores = encoder_scores(model);
    for (std::size_t i = 0; i < e.encoders.size(); ++i) {
      if (!e.judged(i)) continue;
      const Evidence own = believed(e, model.belief(), i);
      const Eigen::VectorXd score = scores.row(static_cast<Eigen::Index>(i));
      if (auto step = likeliest_step(own, score))
        all.push_back({TipTerm::Way::encoder, std::move(*step), i, 0});
      if (auto order = strongest_order(own, score))
        all.push_back({TipTerm::Way::encoder, std::move(*order), i, 0});
    }
  }
  std::erase_if(all, [&](const TipTerm& t) { return chosen(model, t); });
  return all;
}

/// Gain in log-likelihood by columns that stand across all that the model has, at its present weights.
double gain_of(const TipSolution& s, const Eigen::MatrixXd& beyond) {
  for (Eigen::Index i = 0; i < beyond.cols(); ++i)
    if (beyond.col(i).isZero(0)) return 0;
  const Eigen::MatrixXd weighted = s.weight.asDiagonal() * beyond;
  const Eigen::VectorXd score = weighted.transpose() * s.rest;
  Eigen::MatrixXd information = beyond.transpose() * weighted;
  information.diagonal().array() *= 1 + 1e-10;
  return 0.5 * score.dot(information.ldlt().solve(score));
}

/// How many rows say together what one would, were they independent: as blocks of the record say, and as the
/// encoders' quantization along the path says.
double inflation(const TipModel& model, const TipSolution& with, const Eigen::MatrixXd& columns) {
  const auto coordinates = static_cast<Eigen::Index>(model.evidence().axes.size());
  return std::max(TipModel::inflation(with, columns, coordinates),
                  model.quantization_inflation(model.beyond({}, columns)));
}

/// The same of a term that the model has.
double inflation(const TipModel& model, std::size_t term) {
  const auto coordinates = static_cast<Eigen::Index>(model.evidence().axes.size());
  const Eigen::MatrixXd columns = model.columns(model.terms()[term]);
  return std::max(TipModel::inflation(model.solution(), columns, coordinates),
                  model.quantization_inflation(model.beyond({term}, columns)));
}

double p_value(double gain, Eigen::Index coefficients) {
  return gain > 0 ? cdf(complement(boost::math::chi_squared(static_cast<double>(coefficients)), 2 * gain))
                  : 1;
}

/// Rms of what columns add, over the rms of all noise.
double loudness(const TipSolution& s, const Eigen::MatrixXd& columns, const Eigen::VectorXd& coefficients) {
  const Eigen::VectorXd added = columns * coefficients;
  return std::sqrt(s.weight.dot(added.cwiseAbs2()) / static_cast<double>(added.size()));
}

/// What a term must gain beyond a named dimension's.
double penalty(const TipModel& model, const TipTerm& t) {
  if (!t.term.named()) return without_name;
  return t.kinematic() || model.evidence().ordered ? 0 : without_name;
}

/// Quantization at slow speeds is not white, and looks a little like anything that follows the motion: a
/// dimension it resembles least, the best of many orders most.
double times_as_loud(const TipTerm& t) {
  if (t.kinematic()) return 1;
  return t.term.named() ? 1.5 : 2.5;
}

/// What coefficients cost by Bayes' criterion (Schwarz).
double price(const TipModel& model, Eigen::Index coefficients) {
  return 0.5 * static_cast<double>(coefficients) * std::log(static_cast<double>(model.entries().size()));
}

struct Step {
  TipTerm term;
  Eigen::VectorXd theta;  // of the term
  double value = 0;
};

std::optional<Step> next_step(const TipModel& model, const TipSelectOptions& options) {
  std::vector<TipTerm> all = candidates(model, true);
  std::vector<std::pair<double, std::size_t>> passing;
  std::vector<Eigen::MatrixXd> columns;
  for (std::size_t i = 0; i < all.size(); ++i) {
    columns.push_back(model.columns(all[i]));
    const double gain = gain_of(model.solution(), model.beyond({}, columns.back()));
    if (gain > 4) passing.emplace_back(gain, i);
  }
  std::sort(passing.rbegin(), passing.rend());
  if (passing.size() > tried_in_full) passing.resize(tried_in_full);
  std::optional<Step> best;
  double best_value = model.value(model.solution(), model.size());
  for (const auto& [gain, i] : passing) {
    const TipSolution s = model.trial({}, columns[i]);
    const Eigen::VectorXd theta = s.theta.tail(columns[i].cols());
    if (loudness(s, model.beyond({}, columns[i]), theta) < options.least_amplitude * times_as_loud(all[i]))
      continue;
    // Counts are lost whole.
    if (all[i].term.effect.type == "missed_counts" && std::abs(theta[0]) < 0.7) continue;
    const double value = model.value(s, model.size() + columns[i].cols()) - penalty(model, all[i]);
    if (value < best_value + better) continue;
    const double gained =
        (s.log_likelihood - model.solution().log_likelihood) / inflation(model, s, columns[i]);
    if (gained < price(model, columns[i].cols()) + penalty(model, all[i]) + better) continue;
    const bool scanned = !all[i].term.named() || all[i].term.effect.type == "missed_counts";
    const double tests = static_cast<double>(all.size()) * (scanned ? most_orders : 1);
    if (p_value(gained, columns[i].cols()) * tests > options.alpha) continue;
    best_value = value;
    best = Step{std::move(all[i]), theta, value};
  }
  return best;
}

/// Moves a term's order or time constant to where the likelihood is largest.
void reshape(TipModel& model, std::size_t term) {
  TipTerm best = model.terms()[term];
  if (!best.term.reshaped) return;
  const Evidence own = believed(model.evidence(), model.belief(), best.where);
  TipSolution solution = model.solution();
  bool moved = false;
  for (double step = 0.5 * best.term.reach; step > 0.02 * best.term.reach; step /= 2)
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

/// Drops the terms that the model is hardly worse without, the least useful first.
void prune(TipModel& model) {
  for (;;) {
    std::optional<std::size_t> least;
    double best = value_of(model) - better;
    for (std::size_t i = 0; i < model.terms().size(); ++i) {
      const double value = model.value(model.trial({i}, {}), model.size() - model.terms()[i].size());
      if (value > best) best = value, least = i;
    }
    if (!least) return;
    model.remove(*least);
    model.fit();
  }
}

/// Term by term, as long as it pays.
TipModel grown(TipModel model, const TipSelectOptions& options) {
  while (model.terms().size() < options.most_terms) {
    std::optional<Step> step = next_step(model, options);
    if (!step) break;
    TipModel next = model;
    next.add(std::move(step->term), step->theta);
    next.fit();
    reshape(next, next.terms().size() - 1);
    prune(next);
    if (value_of(next) < value_of(model) + 0.5 * better) break;
    model = std::move(next);
  }
  return model;
}

/// The same with all dimensions at once, then less and less of them: where many are off, no single one may
/// show alone.
TipModel with_all_dimensions(TipModel model) {
  for (TipTerm& t : tip_terms(model.evidence(), model.belief())) {
    if (!t.kinematic() || chosen(model, t)) continue;
    // What the others can make already would only be one more name for it.
    if (model.beyond({}, model.columns(t)).isZero(0)) continue;
    model.add(std::move(t), Eigen::VectorXd::Zero(1));
    model.fit();
  }
  prune(model);
  return model;
}

TipModel best_model(TipModel start, const TipSelectOptions& options) {
  TipModel model = grown(std::move(start), options);
  const auto dimensions = std::count_if(model.terms().begin(), model.terms().end(),
                                        [](const TipTerm& t) { return t.kinematic(); });
  if (dimensions < 3) return model;
  TipModel other = with_all_dimensions(model);
  return value_of(other) > value_of(model) + better ? std::move(other) : std::move(model);
}

/// Poses anywhere, in place of those of the record: what even they cannot tell apart, no record can.
TipEvidence anywhere(const TipEvidence& e, const Chain& chain) {
  TipEvidence wide = e;
  const Eigen::Index rows = std::min<Eigen::Index>(100, e.rows());
  wide.tip.setZero(e.tip.rows(), rows);
  wide.joints.resize(e.joints.rows(), rows);
  for (Eigen::Index j = 0; j < wide.joints.rows(); ++j)
    for (Eigen::Index k = 0; k < rows; ++k) {
      const double u =
          unit_interval(random_bits(1, static_cast<std::uint64_t>(k), static_cast<std::uint64_t>(j)));
      wide.joints(j, k) =
          (2 * u - 1) * (chain.independent[static_cast<std::size_t>(j)].prismatic() ? 0.5 : std::numbers::pi);
    }
  for (Evidence& own : wide.encoders)
    for (Eigen::ArrayXd* series : {&own.time, &own.reference, &own.measured, &own.path, &own.velocity,
                                   &own.side, &own.effort, &own.temperature})
      if (series->size() > 0) series->conservativeResize(rows);
  return wide;
}

TipTerm shortened(TipTerm t, Eigen::Index rows) {
  if (t.way == TipTerm::Way::encoder) t.term.columns = t.term.columns.topRows(rows).eval();
  return t;
}

/// Whether the other term can take the place of a chosen one at any pose: both are dimensions.
bool everywhere(const OperationalModel& model, const TipModel& fitted, std::size_t term,
                const TipTerm& other) {
  if (!fitted.terms()[term].kinematic() || !other.kinematic()) return false;
  const TipEvidence wide = anywhere(fitted.evidence(), model.chain);
  TipModel poses(model, wide, false);
  const Eigen::MatrixXd target = poses.columns(shortened(fitted.terms()[term], wide.rows()));
  Eigen::MatrixXd rest = poses.columns(shortened(other, wide.rows()));
  const auto append = [&](const TipTerm& t) {
    rest.conservativeResize(Eigen::NoChange, rest.cols() + t.size());
    rest.rightCols(t.size()) = poses.columns(t);
  };
  for (std::size_t i = 0; i < fitted.terms().size(); ++i)
    if (i != term && fitted.terms()[i].kinematic()) append(shortened(fitted.terms()[i], wide.rows()));
  if (fitted.frames()) {
    append({TipTerm::Way::base, {}, 0, 0});
    append({TipTerm::Way::tool, {}, 0, 0});
  }
  const Eigen::VectorXd fit = rest.completeOrthogonalDecomposition().solve(target);
  return (target - rest * fit).norm() < 1e-6 * target.norm();
}

/// Puts better terms in the place of chosen ones until none is better, then tells what is as good.
void try_others(const OperationalModel& model, TipSelection& s) {
  TipModel& m = s.model;
  for (int round = 0; round < 8; ++round) {
    s.alternatives.clear();
    const std::vector<TipTerm> others = tip_terms(m.evidence(), m.belief());
    bool exchanged = false;
    for (std::size_t i = 0; i < m.terms().size() && !exchanged; ++i) {
      const TipSolution without = m.trial({i}, {});
      TipSolution at_weights = without;
      at_weights.weight = m.solution().weight;
      const double own = gain_of(at_weights, m.beyond({i}, m.columns(m.terms()[i])));
      for (const TipTerm& other : others) {
        if (chosen(m, other)) continue;
        const Eigen::MatrixXd columns = m.columns(other);
        if (gain_of(at_weights, m.beyond({i}, columns)) < own - 2 * as_good - 20) continue;
        const TipSolution swapped = m.trial({i}, columns);
        const double loss = m.value(m.solution(), m.size()) -
                            m.value(swapped, m.size() - m.terms()[i].size() + columns.cols()) +
                            penalty(m, other) - penalty(m, m.terms()[i]);
        if (loss < -better && round < 7) {
          const Eigen::VectorXd theta = swapped.theta.tail(columns.cols());
          m.exchange(i, other, theta);
          m.fit();
          exchanged = true;
          break;
        }
        if (loss < as_good) s.alternatives.push_back({i, other, loss, false});
      }
    }
    if (!exchanged) break;
  }
  for (TipAlternative& a : s.alternatives) a.everywhere = everywhere(model, m, a.term, a.other);
}

/// Axes that stand askew, on top of all that has a name.
void find_tilts(TipSelection& s, const TipSelectOptions& options) {
  const TipModel& m = s.model;
  std::vector<TipTerm> all = tilt_terms(m.belief().chain);
  const auto tests = static_cast<double>(all.size());
  Eigen::MatrixXd extra(m.entries().size(), 0);
  TipSolution now = m.solution();
  for (std::size_t round = 0; round < 6; ++round) {
    std::optional<std::size_t> best;
    TipSolution best_solution;
    double best_value = m.value(now, m.size() + extra.cols());
    for (std::size_t i = 0; i < all.size(); ++i) {
      const Eigen::MatrixXd columns = m.columns(all[i]);
      if (m.beyond({}, columns).colwise().norm().minCoeff() == 0) continue;
      Eigen::MatrixXd wider(extra.rows(), extra.cols() + columns.cols());
      wider << extra, columns;
      const TipSolution with = m.trial({}, wider);
      const double value = m.value(with, m.size() + wider.cols()) - without_name;
      const double gained = (with.log_likelihood - now.log_likelihood) / inflation(m, with, columns);
      if (value < best_value + better || gained < price(m, columns.cols()) + without_name + better ||
          p_value(gained, columns.cols()) * tests > options.alpha ||
          loudness(with, m.beyond({}, columns), with.theta.tail(columns.cols())) < options.least_amplitude)
        continue;
      best_value = value;
      best = i;
      best_solution = with;
    }
    if (!best) break;
    const Eigen::MatrixXd columns = m.columns(all[*best]);
    extra.conservativeResize(Eigen::NoChange, extra.cols() + columns.cols());
    extra.rightCols(columns.cols()) = columns;
    now = best_solution;
    s.tilts.push_back(all[*best]);
    all.erase(all.begin() + static_cast<std::ptrdiff_t>(*best));
  }
  for (std::size_t i = 0; i < s.tilts.size(); ++i)
    s.tilt_sizes.push_back(now.theta.tail(extra.cols()).segment(2 * static_cast<Eigen::Index>(i), 2));
}

/// Whether the tracker's frame and target, taken as unknown, explain more than 9 numbers do by chance.
bool asks_for_frames(const TipModel& model, const TipSelectOptions& options) {
  TipTerm base{TipTerm::Way::base, {}, 0, 0}, tool{TipTerm::Way::tool, {}, 0, 0};
  Eigen::MatrixXd columns(model.entries().size(), 9);
  columns << model.columns(base), model.columns(tool);
  const TipSolution with = model.trial({}, columns);
  const Eigen::Index more = with.rank - model.solution().rank;
  if (more <= 0) return false;
  const double gained =
      (with.log_likelihood - model.solution().log_likelihood) / inflation(model, with, columns);
  return gained > price(model, more) + without_name && p_value(gained, more) < options.alpha &&
         loudness(with, model.beyond({}, columns), with.theta.tail(9)) > 2.5 * options.least_amplitude;
}

}  // namespace

TipSelection select_tip(const OperationalModel& model, const TipEvidence& e,
                        const TipSelectOptions& options) {
  TipModel found = best_model(TipModel(model, e, false), options);
  if (asks_for_frames(found, options)) {
    TipModel framed = best_model(TipModel(model, e, true), options);
    const Eigen::Index free = framed.trial({}, {}).rank - framed.size();
    if (framed.value(framed.solution(), framed.size() + free) >
        found.value(found.solution(), found.size()) + without_name)
      found = std::move(framed);
  }
  TipSelection s{std::move(found), {}, {}, {}, {}};
  try_others(model, s);
  for (std::size_t i = 0; i < s.model.terms().size(); ++i) {
    const TipTerm& t = s.model.terms()[i];
    const double gained = s.model.solution().log_likelihood - s.model.trial({i}, {}).log_likelihood;
    s.p_values.push_back(p_value(gained / inflation(s.model, i), t.size()));
  }
  find_tilts(s, options);
  return s;
}

}  // namespace qerr
