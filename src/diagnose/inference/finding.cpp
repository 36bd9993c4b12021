#include "diagnose/inference/finding.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/parallel.hpp"
#include "core/random.hpp"
#include "core/statistics.hpp"
#include "diagnose/inference/found_parameters.hpp"
#include "diagnose/record/with_effects.hpp"
#include "effect/action_path.hpp"
#include "effect/effects/effects.hpp"
#include "effect/effects/periodic.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "qerr/kinematics/chain.hpp"

namespace qerr {

double size_of(const Explanation& m, std::size_t term) {
  const Eigen::ArrayXd added = addition(m.terms()[term], m.coefficients(term));
  return m.terms()[term].constant ? std::abs(added.mean()) : standard_deviation(added);
}

double mean_square_residual(const Explanation& m, const Evidence& e) {
  return (e.measured - e.reference - m.addition()).square().mean();
}

namespace {

/// The row in first .. last at which an error changes most abruptly: the first one behind its step.
Eigen::Index row_of_step(const Eigen::ArrayXd& error, Eigen::Index first, Eigen::Index last) {
  constexpr Eigen::Index side = 8;  // rows, of which the means before and behind are compared
  const Eigen::Index before = std::min(side, first), behind = std::min(side, error.size() - last);
  const double low = error.segment(first - before, before).mean(), high = error.segment(last, behind).mean();
  double change = 0, least = 0;
  Eigen::Index best = first;
  for (Eigen::Index k = first; k < last; ++k) {
    change += std::pow(error[k] - low, 2) - std::pow(error[k] - high, 2);
    if (change < least) least = change, best = k + 1;
  }
  return best;
}

/// Time of a step, between rows of the record: the search knows it to some of the rows that it uses.
/// @param others  what the other terms add, at the rows of the sampling
double time_of_step(const Sampling& s, double time, const Eigen::ArrayXd& others) {
  constexpr Eigen::Index around = 8;  // groups of rows
  const Eigen::ArrayXd &used = s.evidence.time, &all = s.record->time;
  const Eigen::Index at = std::lower_bound(used.begin(), used.end(), time) - used.begin(), n = used.size();
  if (at < 1 || at + 1 >= n) return time;
  const Eigen::Index there =
      row_of_step(s.evidence.measured - s.evidence.path - others, std::max<Eigen::Index>(at - around, 1),
                  std::min(at + around, n - 1));
  // Rows of the record in both groups beside the step, and between them. A rest is one group, and long.
  const Eigen::Index first = s.groups[static_cast<std::size_t>(there) - 1].first + 1,
                     last = s.groups[static_cast<std::size_t>(there)].end - 1;
  const Eigen::Index row =
      last > first ? row_of_step(s.record->measured - s.record->path, first, last) : first;
  return 0.5 * (all[row - 1] + all[row]);
}

/// The fit with its steps between the rows of the record where they are.
Explanation with_timed_steps(const Sampling& s, Explanation m) {
  const auto is_timed = [](const Term& t) { return t.step && t.named(); };
  std::vector<Term> terms = m.terms();
  if (std::ranges::none_of(terms, is_timed)) return m;
  for (std::size_t i = 0; i < terms.size(); ++i)
    if (is_timed(terms[i])) {
      const Eigen::ArrayXd others = m.addition() - addition(terms[i], m.coefficients(i));
      terms[i] = step_term(s.evidence, time_of_step(s, terms[i].effect.number("time"), others));
    }
  return Explanation(s.evidence, std::move(terms));
}

/// The fit with time constants at the maximum of its likelihood, as their intervals have it: the search ends
/// at a part of its own half-width. Terms without a name may be several for one curve, whose orders would
/// drift apart.
Explanation with_fitted_shapes(const Evidence& e, Explanation m) {
  constexpr int most_steps = 4;
  constexpr double enough = 0.02;  // of log-likelihood: a fifth of the standard deviation
  for (int step = 0; step < most_steps; ++step) {
    std::vector<Term> terms = m.terms();
    std::vector<std::size_t> shaped;
    Explanation wider = m;
    for (std::size_t i = 0; i < terms.size(); ++i) {
      if (!terms[i].named() || shape_name(terms[i]).empty()) continue;
      shaped.push_back(i);
      wider.add(with_columns(terms[i], shape_column(e, terms[i], m.coefficients(i))));
    }
    if (shaped.empty()) break;
    wider.fit();
    for (std::size_t s = 0; s < shaped.size(); ++s) {
      Term& t = terms[shaped[s]];
      const double by = wider.coefficients(terms.size() + s)[0], most = 0.5 * t.half_width;
      t = t.reshaped(e, t, t.shape + std::clamp(by, -most, most));
    }
    Explanation next(e, std::move(terms));
    const double better = next.log_likelihood() - m.log_likelihood();
    if (better > 0) m = std::move(next);
    if (!(better > enough)) break;
  }
  return m;
}

}  // namespace

Selection selection_of(const Sampling& sampling, const FoundCauses& found) {
  std::vector<Term> terms;
  for (const ChosenTerm& c : found.chosen) terms.push_back(c.candidate.over(sampling));
  Explanation fitted(sampling.evidence, std::move(terms));
  Selection s{
      with_fitted_shapes(sampling.evidence, with_timed_steps(sampling, std::move(fitted))), {}, {}, {}};
  for (const ChosenTerm& c : found.chosen) {
    s.p_values.push_back(c.p_value);
    s.lost.push_back(c.lost);
  }
  for (const Replacement& r : found.replacements)
    s.alternatives.push_back({r.instead_of, r.candidate.term->effect});
  return s;
}

namespace {

/// Rows whose likelihood is computed: intervals narrow with their root, and the search has used all.
constexpr Eigen::Index enough_rows = 8192;

/// Rms of a joint's residual before its readings were repaired; empty where they were not.
std::optional<double> before_repair(const Sanity& sane, const std::string& joint) {
  for (const Cause& c : sane.causes)
    if (c.effect.joint == joint && c.gain.rms_before != c.gain.rms_after)
      for (std::size_t i = 0; i < sane.rms_before.size(); ++i)
        if (sane.model.chain.independent[i].name == joint && sane.rms_before[i] > 0)
          return sane.rms_before[i];
  return std::nullopt;
}

/// Scales the squares of all blocks to the residual as recorded, where the gain was computed from repaired
/// readings.
void undo_repair(HeldOut& held, double rms_before) {
  double squares = 0, rows = 0;
  for (const HeldOut::Block& b : held.blocks) squares += b.before, rows += b.rows;
  if (squares <= 0) return;
  const double factor = rms_before * rms_before * rows / squares;
  for (HeldOut::Block& b : held.blocks) b.before *= factor;
}

/// The terms without those that have no name, which a spec cannot state.
std::vector<Term> names_of(const Explanation& m) {
  std::vector<Term> names;
  std::ranges::copy_if(m.terms(), std::back_inserter(names), &Term::named);
  return names;
}

/// Whether a joint's own weight can load it: its axis is not vertical.
bool is_loaded(const OperationalModel& model, const Log& log, Eigen::Index joint) {
  const std::size_t n = model.chain.independent.size();
  Eigen::VectorXd q(static_cast<Eigen::Index>(n));
  for (std::size_t i = 0; i < n; ++i) {
    const auto column = log.find(LogSignal::reference, i);
    if (!column) return true;
    q[static_cast<Eigen::Index>(i)] = log.values(0, *column);
  }
  const Eigen::Vector3d axis = jacobian(model.chain, q).bottomRows<3>().col(joint);
  return axis.head<2>().norm() > 0.1 * axis.norm();
}

bool has_names(const FoundCauses& found) {
  return std::any_of(found.chosen.begin(), found.chosen.end(),
                     [](const ChosenTerm& c) { return c.candidate.term->named(); });
}

void drop(FoundCauses& found, std::size_t term) {
  found.chosen.erase(found.chosen.begin() + static_cast<std::ptrdiff_t>(term));
  std::erase_if(found.replacements, [&](const Replacement& r) { return r.instead_of == term; });
  for (Replacement& r : found.replacements)
    if (r.instead_of > term) --r.instead_of;
}

/// The name that explains least beside all others.
std::size_t least_name(const FoundCauses& found) {
  std::size_t least = found.chosen.size();
  for (std::size_t i = 0; i < found.chosen.size(); ++i)
    if (found.chosen[i].candidate.term->named() &&
        (least == found.chosen.size() || found.chosen[i].lost < found.chosen[least].lost))
      least = i;
  return least;
}

/// A term whose size the fit has made impossible, such as a negative play, an order of which it has left less
/// than half of what is worth a term, or any other of which it has left less than a tenth.
std::optional<std::size_t> impossible_term(const Explanation& m, double step) {
  constexpr double half = 0.5 * material, tenth = 0.1 * material;  // counts
  for (std::size_t i = 0; i < m.terms().size(); ++i) {
    const Term& t = m.terms()[i];
    const Eigen::VectorXd c = m.coefficients(i);
    const double least = t.named() && t.harmonic ? half : tenth,
                 size = t.named() && !t.harmonic ? rms(addition(t, c)) : size_of(m, i);
    if ((t.positive > 0 && c[0] < 0) || size < least * step) return i;
  }
  return std::nullopt;
}

/// Whether the intervals of a term's parameters hold what adds nothing: zero, of those that its coefficients
/// scale, unlike phases and time constants; of signals that are not clipped, level 1.
bool holds_nothing(const Term& t, const Eigen::VectorXd& coefficients,
                   const std::vector<FoundParameter>& found) {
  Effect twice = t.effect;
  t.fill(twice, 2 * coefficients);
  for (const Parameter& of : effect_kind(t.effect.type).parameters)
    for (const FoundParameter& p : found)
      if (p.name == of.name && of.fallback.value_or(0) != 0 && p.upper > p.lower &&
          (p.lower > *of.fallback || p.upper < *of.fallback))
        return false;
  bool any = false;
  for (const FoundParameter& p : found) {
    if (!(std::abs(p.value) > 0) || std::abs(twice.number(p.name) - 2 * p.value) > 1e-6 * std::abs(p.value))
      continue;
    if (p.lower > 0 || p.upper < 0) return false;
    any = true;
  }
  return any;
}

/// A named term of which the fit says no more than that it may be nothing. Of several, the one with the least
/// effect. An exponential that hardly bends in the record has an amplitude as uncertain as its time constant,
/// and is no less certain for that.
std::optional<std::size_t> unestablished_term(const Evidence& e, const Explanation& m) {
  const auto parameters = found_parameters(e, m);
  std::optional<std::size_t> least;
  for (std::size_t i = 0; i < m.terms().size(); ++i)
    if (m.terms()[i].named() && shape_name(m.terms()[i]).empty() &&
        holds_nothing(m.terms()[i], m.coefficients(i), parameters[i]) &&
        (!least || size_of(m, i) < size_of(m, *least)))
      least = i;
  return least;
}

double largest_unnamed(const Explanation& m) {
  double largest = 0;
  for (std::size_t i = 0; i < m.terms().size(); ++i)
    if (!m.terms()[i].named()) largest = std::max(largest, size_of(m, i));
  return largest;
}

/// Size of the displacement of a disc's edges [rad or m]; 0: none was found.
double displaced_edges(const Scatter& s) {
  double size = 0;
  for (const ScatterCause& c : s.causes)
    if (!effect_kind(c.effect.type).random()) size = std::max(size, c.rms);
  return size;
}

/// The mean error that displaced edges have, where no constant of the model is it [rad or m].
double mean_of_edges(const Evidence& e, const Explanation& m, const Scatter& s) {
  if (!e.encoder.zero_known || std::ranges::any_of(m.terms(), &Term::constant)) return 0;
  double mean = 0;
  for (const ScatterCause& c : s.causes)
    if (const EffectKind& kind = effect_kind(c.effect.type); !kind.random() && kind.share)
      mean += kind.share(c.effect, e.encoder, {})->mean;
  return mean;
}

/// @returns whether there was any
bool drop_small_orders(FoundCauses& found, double size) {
  bool any = false;
  for (std::size_t i = found.chosen.size(); i-- > 0;)
    if (found.chosen[i].candidate.term->harmonic && found.chosen[i].rms < size) drop(found, i), any = true;
  return any;
}

/// Whether the names lower the residual of blocks to which they were not fitted, by a tenth of a percent at
/// the least: names that do not only correct uncatalogued shapes.
bool lowers_residual(const HeldOut& held) {
  double before = 0, after = 0;
  for (const HeldOut::Block& b : held.blocks) before += b.before, after += b.after;
  return after < 0.998 * before;
}

/// Terms of a model that is fitted by simulation: each costs a simulation a coefficient and step, and a fit
/// without it for each that turns out needless. More are a curve's table of orders, not causes.
constexpr std::size_t most_simulated = 12;

/// The causes with an alternative in the place of one of them, without those that it makes needless:
/// harmonics and the mean of a shape are no causes of their own. Empty where none of them becomes needless,
/// or more remains. Physics decides: what the simulation of all leaves.
std::optional<FoundCauses> fewer_causes(const Sampling& sampling, const FoundCauses& found,
                                        const Explanation& model) {
  constexpr double as_much = 1.01;
  if (found.chosen.size() > most_simulated) return std::nullopt;
  for (const Replacement& r : found.replacements) {
    // Less than half a period needs no offset beside it, and is none the likelier for that.
    const Term& t = *r.candidate.term;
    if (t.harmonic && periods_covered(t.effect, sampling.evidence) < distinct_periods) continue;
    FoundCauses other = found;
    other.chosen[r.instead_of].candidate = r.candidate;
    other.replacements.clear();
    bool any = false;
    std::optional<Explanation> fitted;
    while (other.chosen.size() > 1) {  // each round has one term less
      fitted = simulated_fit(sampling, selection_of(sampling, other).model);
      const auto needless = needless_term(*fitted);
      if (!needless) break;
      drop(other, *needless);
      any = true;
    }
    if (any && fitted &&
        left_by_simulation(sampling, *fitted) < as_much * left_by_simulation(sampling, model))
      return other;
  }
  return std::nullopt;
}

/// The causes with periodic errors of the joint in the place of the disc's, where their simulation leaves
/// less: at ratio 1 both turn alike, but for what displaces the disc.
std::optional<FoundCauses> with_joint_shafts(const Sampling& sampling, FoundCauses found,
                                             const Explanation& model) {
  if (sampling.evidence.encoder.shaft_ratio != 1) return std::nullopt;
  bool any = false;
  for (std::size_t i = 0; i < found.chosen.size(); ++i) {
    const Term& t = model.terms()[i];
    if (!t.named() || refers_to_joint(t.effect)) continue;
    const EffectKind& kind = effect_kind(t.effect.type);
    if (!is_periodic(kind)) continue;
    any = any || std::ranges::any_of(model.terms(), [&](const Term& by) {
            return by.named() && acts_before(effect_kind(by.effect.type), kind);
          });
    found.chosen[i].candidate.over = [of_disc = found.chosen[i].candidate.over](const Sampling& s) {
      Term of_joint = of_disc(s);
      of_joint.effect.choices["shaft"] = "joint";
      return of_joint;
    };
  }
  if (!any || !(left_by_simulation(sampling, selection_of(sampling, found).model) <
                left_by_simulation(sampling, model)))
    return std::nullopt;
  return found;
}

/// Those groups of rows that the clocks found read within the record.
std::vector<RowGroup> rows_within(const Evidence& record, const FoundCauses& found,
                                  std::vector<RowGroup> all) {
  std::vector<Effect> effects;
  for (const ChosenTerm& c : found.chosen)
    if (c.candidate.term->named() && effect_kind(c.candidate.term->effect.type).stage == Stage::clock)
      c.candidate.term->fill(effects.emplace_back(c.candidate.term->effect), c.coefficients);
  if (effects.empty() || !record.ordered) return all;
  const auto within = reads_within(record, effects, record.time);
  std::vector<RowGroup> some;
  for (const RowGroup& g : all)
    if (within.segment(g.first, g.end - g.first).all()) some.push_back(g);
  const auto least = least_part_within * static_cast<double>(all.size());
  return static_cast<double>(some.size()) >= least ? some : all;
}

std::unique_ptr<Finding> finding_of(const Evidence& record, const Sanity& sane, std::uint64_t seed) {
  auto f = std::make_unique<Finding>();
  FoundCauses found = search_causes(record, seed);
  f->sampling.emplace(record, rows_within(record, found, independent_rows(record, seed, enough_rows)));
  const auto select = [&] {
    f->selection.emplace(selection_of(*f->sampling, found));
    while (const auto impossible =
               impossible_term(f->selection->model, record.step())) {  // of finitely many terms
      drop(found, *impossible);
      f->selection.emplace(selection_of(*f->sampling, found));
    }
    f->held = hold_out(record, f->evidence(), f->sampling->groups, names_of(f->selection->model));
  };
  // Where the simulation of the causes leaves more than they do, or something is left, it is fitted itself.
  // Each round has one term less.
  const auto fit_by_simulation = [&] {
    if (found.chosen.size() > most_simulated || is_reproduced(*f->sampling, f->selection->model)) return;
    if (auto other = with_joint_shafts(*f->sampling, found, f->selection->model)) {
      found = std::move(*other);
      select();
      if (is_reproduced(*f->sampling, f->selection->model)) return;
    }
    while (has_names(found)) {
      Explanation fitted = simulated_fit(*f->sampling, f->selection->model);
      auto needless = needless_term(fitted);
      if (!needless) needless = impossible_term(fitted, record.step());
      if (needless) {
        drop(found, *needless);
        select();
        continue;
      }
      f->selection->model = std::move(fitted);
      f->held = hold_out(record, f->evidence(), f->sampling->groups, names_of(f->selection->model));
      return;
    }
  };
  select();
  // Each round has one name less, and a search without names, which follows the last one, finds none.
  while (has_names(found) && !lowers_residual(f->held)) {
    drop(found, least_name(found));
    if (!has_names(found)) found = search_causes(record, seed, false);
    select();
  }
  fit_by_simulation();
  if (auto fewer = fewer_causes(*f->sampling, found, f->selection->model)) {
    found = std::move(*fewer);
    select();
    fit_by_simulation();
  }
  // After the last fit: a linear one that is far off has wide intervals. Each round has one term less.
  while (const auto unestablished = unestablished_term(f->evidence(), f->selection->model)) {
    drop(found, *unestablished);
    select();
    fit_by_simulation();
  }
  f->visible = found.visible;
  f->scatter = scatter_of(f->evidence(), f->selection->model, largest_unnamed(f->selection->model));
  // Displaced edges have any high order where the rows beat with them.
  if (const double displaced = displaced_edges(f->scatter); drop_small_orders(found, 0.5 * displaced)) {
    select();
    fit_by_simulation();
    f->scatter = scatter_of(f->evidence(), f->selection->model, largest_unnamed(f->selection->model));
  }
  // A curve that begins at zero, such as a drift, would bend to hold the mean of displaced edges.
  const double mean = mean_of_edges(f->evidence(), f->selection->model, f->scatter);
  if (mean != 0) {
    f->sampling->evidence.path += mean;
    select();
    fit_by_simulation();
    f->scatter = scatter_of(f->evidence(), f->selection->model, largest_unnamed(f->selection->model));
  }
  const Explanation& m = f->selection->model;
  const double unnamed = largest_unnamed(m), rounding = record.step() * record.step() / 12;
  f->remainder = remainder_of(f->evidence(), m, f->scatter, unnamed);
  f->sampling->evidence.path -= mean;  // what is left, as a figure, includes it
  f->simulated = simulated_readings(*f->sampling, m);
  f->held.predicted = expected_squares(f->evidence(), m.addition(), f->scatter.expected - rounding) +
                      static_cast<double>(f->evidence().rows()) * std::pow(mean / record.step(), 2);
  if (const auto before = before_repair(sane, record.joint)) undo_repair(f->held, *before);
  return f;
}

}  // namespace

std::vector<std::unique_ptr<Finding>> findings_of(std::vector<Evidence> all, const Sanity& sane,
                                                  const DiagnoseOptions& options) {
  for (Evidence& e : all) {
    e.loaded = is_loaded(sane.model, sane.log, e.number);
    for (const Evidence& other : all)
      if (&other != &e && other.rows() == e.rows() && !other.is_stationary()) e.others.push_back(&other);
  }
  std::vector<std::unique_ptr<Finding>> findings(all.size());
  const auto find = [&](bool coupled) {
    parallel_for(all.size(), options.threads, [&](std::size_t i) {
      if (all[i].coupled() == coupled)
        findings[i] = finding_of(all[i], sane, stream_seed(options.seed, "rows", i));
    });
  };
  find(false);
  std::vector<Effect> found;
  for (const auto& f : findings)
    if (f)
      for (Effect& effect : named_effects(f->selection->model)) found.push_back(std::move(effect));
  add_coupled_effects(all, sane.model.transmission, found);
  find(true);
  return findings;
}

bool has_reversed_effort(const Evidence& e, std::uint64_t seed) {
  constexpr double worth_a_search = 0.95;  // of the error's deviation, that the effort alone leaves
  if (e.effort.size() == 0 || !e.driven || e.is_stationary()) return false;
  const Eigen::ArrayXd error = e.measured - e.path;
  const Line line = fit_line(e.effort, error);
  if (line.slope >= 0 || line.residual_rms > worth_a_search * standard_deviation(error)) return false;
  const std::vector<ChosenTerm> chosen = search_causes(e, seed).chosen;
  return std::any_of(chosen.begin(), chosen.end(), [](const ChosenTerm& c) {
    return c.candidate.term->effect.type == compliance_effect().name && c.coefficients[0] < 0;
  });
}

}  // namespace qerr
