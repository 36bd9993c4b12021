#include "diagnose/search/term_choice.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "diagnose/record/with_effects.hpp"
#include "effect/effects/effects.hpp"

namespace qerr {

namespace {

/// Part of what all terms explain that the leading names must reach to come first, and what makes a leading
/// name.
constexpr double named_share = 0.7, leading_part = 0.05;

/// 1 + 2 sum of the autocorrelation (initial positive sequence, Geyer 1992).
double integrated_correlation(const Eigen::ArrayXd& x) {
  const Eigen::Index n = x.size(), longest = n / 16;
  const double power = x.square().sum();
  if (!(power > 0)) return 1;
  const auto product = [&](Eigen::Index lag) { return (x.head(n - lag) * x.tail(n - lag)).sum(); };
  double sum = 1;
  for (Eigen::Index lag = 1; lag + 1 <= longest; lag += 2) {
    const double pair = (product(lag) + product(lag + 1)) / power;
    if (pair <= 0) break;
    sum += 2 * pair;
  }
  return std::clamp(sum, 1.0, std::max(1.0, static_cast<double>(longest)));
}

template <typename Which>
void allow(ErrorModel& m, const ChoiceHistory& history, Which which) {
  m.allow([&](std::size_t i) {
    const std::vector<std::string>& refuted = history.refuted;
    if (!history.names && m.term(i).named()) return false;
    if (m.candidate(i).replaces_only && !(history.arcs && m.term(i).effect.number("order") == 1))
      return false;
    return which(i) && std::find(refuted.begin(), refuted.end(), m.candidate(i).family) == refuted.end();
  });
}

/// The allowed groups of the families that the previous pass has found.
LinearModel::Set previous(const ErrorModel& m, const ChoiceHistory& history) {
  LinearModel::Set set;
  for (const std::string& family : history.found)
    for (std::size_t i = 0; i < m.candidates().size(); ++i)
      if (m.candidate(i).family == family && m.group(i).allowed) {
        set.push_back(i);
        break;
      }
  return m.possible(set, m.fit(set)) ? set : LinearModel::Set{};
}

/// Number of causes, of which all orders of a shaft are one.
std::size_t count_causes(const ErrorModel& m, const LinearModel::Set& set) {
  std::vector<std::string> causes;
  std::size_t steps = 0;
  for (const std::size_t g : set) {
    const Term& t = m.term(g);
    if (t.constant) continue;
    if (t.step) {
      ++steps;
      continue;
    }
    const auto shaft = t.effect.choices.find("shaft");
    const std::string cause =
        t.harmonic && shaft != t.effect.choices.end() ? "shaft " + shaft->second : t.effect.type;
    if (std::find(causes.begin(), causes.end(), cause) == causes.end()) causes.push_back(cause);
  }
  return causes.size() + steps;
}

/// The names that come first where nothing explains everything: those that explain a twentieth of what names
/// can explain, if they are few and explain nearly as much as the best model. Real errors differ from the
/// textbook's shapes, and a table of any curve fits better than a name; but it tells nothing.
LinearModel::Set leading_names(const ErrorModel& m, const LinearModel::Set& names,
                               const LinearModel::Set& best) {
  const double nothing = m.fit({}).rss, with_names = m.fit(names).rss, all = nothing - m.fit(best).rss;
  LinearModel::Set core;
  for (std::size_t i = 0; i < names.size(); ++i) {
    // Steps and exponentials are functions of time alone, of which a table is only the better version.
    const Term& t = m.term(names[i]);
    if (t.step || t.reshaped) continue;
    LinearModel::Set without = names;
    without.erase(without.begin() + static_cast<std::ptrdiff_t>(i));
    if (m.fit(without).rss - with_names > leading_part * (nothing - with_names)) core.push_back(names[i]);
  }
  const double explained = nothing - m.fit(core).rss;
  if (explained < named_share * all || count_causes(m, core) > best.size()) return {};
  return core;
}

/// The best of the sets that the search reaches from nothing, from the best named terms and from what the
/// previous pass has found: a table can take the place of any one of several named terms that together need
/// fewer coefficients.
/// @param names  receives the best named terms
LinearModel::Set best_of_starts(ErrorModel& m, const ChoiceHistory& history, double independent,
                                LinearModel::Set& names) {
  m.price(independent, history.worth_of_shapes, history.worth_of_shapes);
  allow(m, history, [&](std::size_t i) { return m.term(i).named(); });
  names = m.search({previous(m, history), {}}, independent);
  m.price(independent, history.worth, history.worth_of_shapes);
  allow(m, history, [](std::size_t) { return true; });
  const LinearModel::Set best = m.search({names, {}, previous(m, history)}, independent);
  // Names alone that leave nothing need not be worth more than the curves that do.
  m.price(independent, history.worth_of_shapes, history.worth_of_shapes);
  const double duration = m.sampled().ordered ? m.sampled().time.maxCoeff() : 0;
  const bool straight = std::any_of(names.begin(), names.end(), [&](std::size_t g) {
    return m.term(g).reshaped && !m.term(g).harmonic && m.term(g).shape >= 2 * duration;
  });  // an exponential that does not bend within the record
  if (!straight && m.is_complete(names) && m.criterion(names, independent) <= m.criterion(best, independent))
    return names;
  m.price(independent, history.worth, history.worth_of_shapes);
  if (m.is_complete(best)) return best;
  const LinearModel::Set core = leading_names(m, names, best);
  if (core.empty()) return best;
  m.price(independent, history.worth_of_shapes, history.worth_of_shapes);
  return m.search(core, core.size(), independent);
}

/// A set with whole steps in the place of ramps and approaches that leave hardly less: beside a large
/// remainder a name has to be worth more than a guess, for the idealization of its shape, and a step has
/// none.
LinearModel::Set with_whole_steps(const ErrorModel& m, LinearModel::Set set) {
  for (std::size_t i = 0; i < set.size(); ++i) {
    const std::size_t guess = set[i];
    if (!m.is_transition(guess)) continue;
    for (std::size_t g = 0; g < m.candidates().size(); ++g) {
      if (!m.term(g).whole || m.candidate(g).family != m.candidate(guess).family || !m.group(g).allowed)
        continue;
      LinearModel::Set whole = set;
      whole[i] = g;
      // Half of a guess's least gain is what it must be better by than a name.
      if (m.fit(whole).rss - m.fit(set).rss < 0.5 * m.group(guess).least_gain) set = std::move(whole);
      break;
    }
  }
  return set;
}

}  // namespace

Choice choose_terms(ErrorModel& m, const ChoiceHistory& history) {
  Choice c;
  const double known = m.correlation();
  c.richest = with_whole_steps(m, best_of_starts(m, history, m.rows() / known, c.named));
  const Eigen::ArrayXd residual = m.residual(c.richest, m.fit(c.richest)) * m.weight().sqrt();
  c.correlation = m.sampled().ordered ? std::max(known, integrated_correlation(residual)) : 1;
  c.structured = c.correlation >= 1.5 * known;
  c.chosen = !c.structured
                 ? c.richest
                 : with_whole_steps(m, best_of_starts(m, history, m.rows() / c.correlation, c.named));
  c.fit = m.fit(c.chosen);
  c.residual = m.residual(c.chosen, c.fit);
  return c;
}

namespace {

double hypotheses_of(const std::vector<Scanned::Rate>& rates, double value) {
  for (const Scanned::Rate& r : rates)
    if (r.value == value) return r.hypotheses;
  return rates.empty() ? 1 : rates.front().hypotheses;
}

/// Whether a rate was already kept at its refined value.
bool is_refined(const Term& t, const std::vector<Scanned::Rate>& rates) {
  return std::any_of(rates.begin(), rates.end(),
                     [&](const Scanned::Rate& r) { return std::abs(r.value - t.shape) <= t.half_width; });
}

class Refinement {
 public:
  Refinement(const ErrorModel& m, const Choice& choice, const Scanned& scanned)
      : m_(m), choice_(choice), scanned_(scanned) {}

  bool refine() {
    refine_reshaped(choice_.chosen, choice_.fit, 0.005);
    refine_time_constants();
    refine_travel();
    for (std::size_t i = 0; i < choice_.chosen.size(); ++i) keep_size(i);
    keep_clocks_of_names();
    for (const LinearModel::Set* set : {&choice_.chosen, &choice_.richest})
      for (const std::size_t g : *set) keep(m_.candidate(g));
    return changed_;
  }

  Scanned next;

 private:
  const Term& term(std::size_t i) const { return m_.term(choice_.chosen[i]); }
  Eigen::VectorXd coefficients(std::size_t i) const {
    return m_.coefficients(choice_.chosen, choice_.fit, i);
  }

  /// A column for the derivative by each shape beside the chosen terms.
  /// @param matters  part of the half-width by which a change calls for another pass
  void refine_reshaped(const LinearModel::Set& set, const LinearModel::Fit& fit, double matters) {
    std::vector<std::size_t> shaped;
    for (std::size_t i = 0; i < set.size(); ++i)
      if (m_.term(set[i]).reshaped) shaped.push_back(i);
    if (shaped.empty()) return;
    Eigen::MatrixXd columns = m_.columns(set);
    const Eigen::Index count = columns.cols();
    columns.conservativeResize(Eigen::NoChange, count + static_cast<Eigen::Index>(shaped.size()));
    for (std::size_t s = 0; s < shaped.size(); ++s) {
      const Term& t = m_.term(set[shaped[s]]);
      const double by = 1e-3 * t.half_width;
      const Eigen::ArrayXXd change = t.reshaped(m_.sampled(), t, t.shape + by).columns -
                                     t.reshaped(m_.sampled(), t, t.shape - by).columns;
      columns.col(count + static_cast<Eigen::Index>(s)) =
          change.matrix() * m_.coefficients(set, fit, shaped[s]) / (2 * by);
    }
    const LinearModel linear(columns, m_.samples().error.matrix(), m_.weight().matrix(), columns.cols());
    const LinearModel::Fit f = linear.fit({}, {});
    for (std::size_t s = 0; s < shaped.size(); ++s) {
      const Term& t = m_.term(set[shaped[s]]);
      const double by = std::clamp(f.coefficients[count + static_cast<Eigen::Index>(s)], -0.5 * t.half_width,
                                   0.5 * t.half_width);
      changed_ |= std::abs(by) > matters * t.half_width;
      keep_shape(t, t.shape + (std::isfinite(by) ? by : 0.0));
    }
  }

  /// Curves of time that are not named fit an exponential that is nearly right as well as a name does that is
  /// exact: the best named terms have the time constants that they need, chosen or not.
  void refine_time_constants() {
    if (choice_.named == choice_.chosen) return;
    const bool shaped = std::any_of(choice_.named.begin(), choice_.named.end(), [&](std::size_t g) {
      const Term& t = m_.term(g);
      return t.reshaped && !t.harmonic && t.pattern != Shape::line;
    });
    if (shaped) refine_reshaped(choice_.named, m_.fit(choice_.named), 1e-3);
  }

  void keep_shape(const Term& t, double shape) {
    if (t.pattern == Shape::line)
      next.lines.push_back({shape, hypotheses_of(scanned_.lines, t.shape)});
    else if (t.harmonic)
      next.orders.push_back({shape, hypotheses_of(scanned_.orders, t.shape)});
    else
      next.time_constants.push_back(std::max(shape, 0.1 * t.shape));
  }

  /// Parameters of a non-linear term by Gauss-Newton steps on the error that the other named terms leave.
  Eigen::VectorXd parameters_of_linearization(std::size_t i) const {
    constexpr int steps = 6;
    const Term original = m_.candidate(choice_.chosen[i]).over(m_.samples().sampling);
    Eigen::VectorXd p = coefficients(i).head(original.size());
    Eigen::ArrayXd target = choice_.residual;
    for (std::size_t k = 0; k < choice_.chosen.size(); ++k)
      if (k == i || !term(k).named()) target += addition(term(k), coefficients(k));
    for (int step = 0; step < steps; ++step) {
      const Term t = original.relinearized(m_.sampled(), original, p);
      Eigen::MatrixXd columns(target.size(), t.size() + 1);
      columns << Eigen::VectorXd::Ones(target.size()), t.columns.matrix();
      Eigen::VectorXd left = target.matrix();
      if (t.fixed.size() > 0) left -= t.fixed.matrix();
      const LinearModel linear(columns, left, m_.weight().matrix(), columns.cols());
      const Eigen::VectorXd better = linear.fit({}, {}).coefficients.tail(t.size());
      if (!better.allFinite()) break;
      p = better;
    }
    return p;
  }

  /// Keeps the size of a chosen hysteresis, and the parameters of a chosen linearization.
  void keep_size(std::size_t i) {
    if (term(i).relinearized) {
      const Scanned::Linearization now{term(i).effect.type, parameters_of_linearization(i)};
      const Eigen::VectorXd& p = now.parameters;
      changed_ |= std::none_of(scanned_.linearizations.begin(), scanned_.linearizations.end(),
                               [&](const Scanned::Linearization& before) {
                                 return before.effect == now.effect && before.parameters.size() == p.size() &&
                                        (p - before.parameters).norm() <= 0.01 * p.norm();
                               });
      next.linearizations.push_back(now);
    }
    if (is_clock(term(i)) && !term(i).relinearized) keep_clock(term(i), coefficients(i));
    if (!term(i).hysteresis) return;
    const double size = coefficients(i)[0];
    changed_ |= scanned_.hystereses.empty() || std::abs(size - scanned_.hystereses.front()) > 0.02 * size;
    next.hystereses.push_back(size);
  }

  static bool is_clock(const Term& t) {
    return t.named() && effect_kind(t.effect.type).stage == Stage::clock;
  }

  /// Keeps the parameter of a clock, which is that of its term.
  void keep_clock(const Term& t, const Eigen::VectorXd& p) {
    changed_ |= std::none_of(scanned_.linearizations.begin(), scanned_.linearizations.end(),
                             [&](const Scanned::Linearization& before) {
                               return before.effect == t.effect.type && before.parameters.size() == 1 &&
                                      std::abs(p[0] - before.parameters[0]) <= 0.01 * std::abs(p[0]);
                             });
    next.linearizations.push_back({t.effect.type, p});
  }

  /// Curves without a name follow a shift in time whose size the series has not met: as with time constants,
  /// the best named terms have the clocks that they need, chosen or not.
  void keep_clocks_of_names() {
    const LinearModel::Set& names = choice_.named;
    const LinearModel::Fit fit = m_.fit(names);
    for (std::size_t i = 0; i < names.size(); ++i) {
      const Term& t = m_.term(names[i]);
      const auto is_own = [&](const Scanned::Linearization& l) { return l.effect == t.effect.type; };
      if (!is_clock(t) || std::any_of(next.linearizations.begin(), next.linearizations.end(), is_own))
        continue;
      const Eigen::VectorXd p = m_.coefficients(names, fit, i).head(1);
      Effect clock = t.effect;
      t.fill(clock, p);
      if (reads_within(m_.record(), {clock}, m_.record().time).cast<double>().mean() >= least_part_within)
        keep_clock(t, p);
    }
  }

  /// The travel of the friction that leaves least beside what is no hysteresis, between neighbours at half
  /// the previous ratio. A play may stand for one whose travel the series has not met.
  void refine_travel() {
    // The first is about the root of the ratio of the dictionary's series.
    constexpr double first = 1.8, fine = 1.03;
    const auto travels = [](const Term& t) { return t.effect.numbers.find("travel"); };
    LinearModel::Set others;
    bool friction = false;
    for (std::size_t i = 0; i < choice_.chosen.size(); ++i) {
      const bool here = travels(term(i)) != term(i).effect.numbers.end();
      friction |= here;
      if (!here && !term(i).hysteresis) others.push_back(choice_.chosen[i]);
    }
    if (others.size() == choice_.chosen.size() || (!friction && m_.is_complete(choice_.chosen))) return;
    others.push_back(0);
    double least = std::numeric_limits<double>::infinity(), best = 0;
    for (std::size_t g = 0; g < m_.candidates().size(); ++g) {
      const auto travel = travels(m_.term(g));
      if (travel == m_.term(g).effect.numbers.end()) continue;
      others.back() = g;
      if (const LinearModel::Fit f = m_.fit(others); f.regular && f.rss < least)
        least = f.rss, best = travel->second;
    }
    if (best == 0) return;
    const std::vector<double>& before = scanned_.travels;
    const double ratio = before.empty() ? first : std::max(fine, std::sqrt(before[0] / before[1]));
    next.travels = {ratio * best, best, best / ratio};
    changed_ |= ratio > fine;
  }

  /// Keeps what a term of a scan needs to be found again.
  void keep(const Candidate& c) {
    const Term& t = *c.term;
    const auto add = [](auto& list, const auto& item, auto value) {
      if (std::none_of(list.begin(), list.end(),
                       [&](const auto& other) { return value(other) == value(item); }))
        list.push_back(item);
    };
    const auto rate = [](const Scanned::Rate& r) { return r.value; };
    const double order = t.effect.number_or("order", 0);
    if (t.harmonic && t.named())
      add(next.orders, Scanned::Rate{std::abs(wave_number(t.effect, m_.sampled().encoder)), 1, true}, rate);
    else if (t.harmonic && !is_refined(t, next.orders))
      add(next.orders, Scanned::Rate{t.shape, hypotheses_of(scanned_.orders, t.shape)}, rate);
    else if (t.pattern == Shape::line && !is_refined(t, next.lines))
      add(next.lines, Scanned::Rate{t.shape, hypotheses_of(scanned_.lines, t.shape)}, rate);
    else if (c.family.rfind("loaded order", 0) == 0)
      add(next.loaded_orders, Scanned::Rate{order, hypotheses_of(scanned_.loaded_orders, order)}, rate);
    else if (c.family.rfind("event", 0) == 0)
      add(next.events, scanned_.events[c.scanned], [](const Event& e) { return e.time; });
    else if (c.family.rfind("bump", 0) == 0)
      add(next.places, scanned_.places[c.scanned], [](const Bump& p) { return p.position; });
  }

  const ErrorModel& m_;
  const Choice& choice_;
  const Scanned& scanned_;
  bool changed_ = false;
};

}  // namespace

bool refine_shapes(const ErrorModel& m, const Choice& choice, Scanned& scanned) {
  Refinement r(m, choice, scanned);
  const bool changed = r.refine();
  scanned = std::move(r.next);
  return changed;
}

}  // namespace qerr
