#include "diagnose/search/cause_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/statistics.hpp"
#include "diagnose/record/with_effects.hpp"
#include "diagnose/search/error_model.hpp"
#include "diagnose/search/residual_scan.hpp"
#include "diagnose/search/term_choice.hpp"
#include "qerr/effect/effect_kind.hpp"

namespace qerr {

namespace {

constexpr int most_passes = 7;

/// Smallest part of the largest error that is worth a term, since the shapes are idealizations: no gear has
/// exact sines.
constexpr double material_part = 0.012;

/// The smallest part beside a joint that coasts through its play: real flanks are springs, from which it
/// bounces. Calibration: what two masses with springs leave (tests/diagnose/coasting_joint_test.cpp).
constexpr double material_part_of_coasting = 0.03;

/// The smallest part for a table or polynomial, which follows a curve that is not its own only coarsely, and
/// of any uncatalogued term of a model that does not explain everything.
constexpr double material_part_of_table = 0.2;

/// At rest only a constant error is visible: one that rounding and noise do not have. It is a name.
FoundCauses at_rest(const Evidence& record, bool with_names) {
  const double mean = (record.measured - record.path).mean();
  if (!with_names || !record.encoder.zero_known || std::abs(mean) < record.step() + 4 * record.path_noise)
    return {};
  const auto constant = [](const RecordSignals& s) {
    std::vector<Term> all = named_terms(s);
    return *std::find_if(all.begin(), all.end(), [](const Term& t) { return t.constant; });
  };
  FoundCauses found;
  ChosenTerm offset;
  offset.candidate.term = std::make_shared<const Term>(constant(record));
  offset.candidate.family = offset.candidate.term->effect.type;
  offset.candidate.over = [constant](const Sampling& s) { return constant(s.evidence); };
  offset.coefficients = Eigen::VectorXd::Constant(1, mean);
  offset.p_value = 0;
  offset.lost = mean * mean, offset.rms = std::abs(mean);
  found.chosen.push_back(std::move(offset));
  return found;
}

/// Largest amplitude of an order, as an angle of its shaft [rad]: a magnet off its axis has up to 2.4 deg,
/// and twice that is a machine that no one would run.
constexpr double largest_amplitude = 0.1;

bool has_possible_size(const ErrorModel& m, std::size_t order, const Eigen::VectorXd& coefficients) {
  const Effect& effect = m.term(order).effect;
  const double of_shaft = std::abs(wave_number(effect, m.sampled().encoder)) / effect.number("order");
  return coefficients.norm() * of_shaft <= largest_amplitude;
}

class CauseSearch {
 public:
  CauseSearch(const Evidence& record, std::uint64_t seed, bool with_names)
      : record_(record),
        seed_(seed),
        samples_(error_samples(record, seed, most_samples)),
        dictionary_(samples_.sampling) {
    history_.names = with_names;
  }

  FoundCauses found() {
    if (samples_.size() < fewest_samples) return at_rest(record_, history_.names);
    history_.worth = history_.worth_of_shapes = material * record_.step();
    for (int pass = 0; pass < most_passes; ++pass) {
      rebuild();
      if (!learn(pass == 0)) break;
    }
    // Both loops end: no choice has a refuted family, and the dictionary has finitely many families.
    while (refute(without_contrast(*model_, choice_)) || refute(outweighed(*model_, choice_))) choose();
    while (refute(brought_by_rounding(*model_, choice_, seed_))) choose();
    free_orders();
    admit_arcs();
    distinguish_steps(*model_, choice_);
    return found_causes(*model_, choice_);
  }

 private:
  const Term& term(std::size_t i) const { return model_->term(choice_.chosen[i]); }
  Eigen::ArrayXd added(std::size_t i) const {
    return addition(term(i), model_->coefficients(choice_.chosen, choice_.fit, i));
  }
  std::vector<std::string> families(const LinearModel::Set& set) const {
    std::vector<std::string> names;
    for (const std::size_t g : set) names.push_back(model_->candidate(g).family);
    return names;
  }

  /// The model of what has been scanned, and its choice.
  void rebuild() {
    model_.emplace(record_, samples_, dictionary_.candidates(scanned_, displacing_), scanned_.events,
                   clocks_of(samples_.sampling.evidence, scanned_), excess_);
    choose();
  }

  void choose() {
    choice_ = choose_terms(*model_, history_);
    history_.found = families(choice_.richest);
  }

  /// Updates what the next pass depends on.
  /// @returns whether anything changed
  bool learn(bool first) {
    bool changed = displace();
    changed |= reweigh();
    changed |= raise_worth();
    changed |= refine_shapes(*model_, choice_, scanned_);
    // Once a scan has added nothing to the model, another one would only find the same.
    std::vector<std::string> now = families(choice_.chosen);
    std::sort(now.begin(), now.end());
    if (first || now != families_) changed |= scan(first);
    families_ = std::move(now);
    return changed;
  }

  /// Whether a term displaces others so that the search has to follow: lines of an encoder are so narrow that
  /// any error of its disc does.
  bool is_followed(const Term& t) const {
    if (displaces(t)) return true;
    for (std::size_t g = 0; g < model_->candidates().size(); ++g)
      if (const Term& other = model_->term(g); t.named() && other.named() && displaces(t, other) &&
                                               effect_kind(other.effect.type).stage == Stage::line)
        return true;
    return false;
  }

  bool displace() {
    std::vector<Addition> now;
    Eigen::ArrayXd change = Eigen::ArrayXd::Zero(samples_.size());
    for (std::size_t i = 0; i < choice_.chosen.size(); ++i)
      if (is_followed(term(i))) now.push_back({term(i), added(i)});
    for (const Addition& a : now) change += a.added;
    for (const Addition& a : displacing_) change -= a.added;
    const bool changed = change.abs().maxCoeff() > 2 * record_.step();
    if (changed) displacing_ = std::move(now);
    return changed;
  }

  /// What is left beyond the stated variance: in its mean, and, where it is independent from row to row, as
  /// the slower and the faster half of the samples have it. A structure that is still to be found is no
  /// jitter.
  bool reweigh() {
    const Eigen::ArrayXd used = (model_->weight() > 0).cast<double>();
    const double rows = model_->rows(), free = static_cast<double>(choice_.fit.coefficients.size());
    const Eigen::ArrayXd squares =
        choice_.residual.square() * rows / std::max(1.0, rows - free) - samples_.variance;
    const Eigen::ArrayXd speed = samples_.sampling.evidence.velocity.square();
    const auto mean = [&](const Eigen::ArrayXd& x, const Eigen::ArrayXd& of) {
      return (x * of).sum() / std::max(1.0, of.sum());
    };
    ExcessVariance now{std::max(0.0, mean(squares, used)), 0};
    const double middle = median({speed.begin(), speed.end()});
    const Eigen::ArrayXd fast = used * (speed > middle).cast<double>(), slow = used - fast;
    const double apart = mean(speed, fast) - mean(speed, slow);
    if (!choice_.structured && apart > 0) {
      now.per_speed = std::max(0.0, (mean(squares, fast) - mean(squares, slow)) / apart);
      now.constant = std::max(0.0, mean(squares, slow) - now.per_speed * mean(speed, slow));
    }
    const double before = mean(excess_.at(samples_.sampling.evidence), used),
                 after = mean(now.at(samples_.sampling.evidence), used);
    const bool changed = std::abs(after - before) > 0.1 * (after + model_->mean_of_used(samples_.variance));
    excess_ = now;
    return changed;
  }

  bool raise_worth() {
    double worth = material * record_.step(), of_shapes = worth;
    const bool incomplete = !model_->is_complete(choice_.chosen);
    // Names that leave white noise, or no more than rounding, are no idealizations here.
    constexpr double no_more = 1.2;  // times the least variance, which is 0.9 of that expected
    const bool white = !choice_.structured || choice_.fit.rss < no_more * model_->floor() * model_->rows();
    const bool exact = !incomplete && white &&
                       std::all_of(choice_.chosen.begin(), choice_.chosen.end(),
                                   [&](std::size_t g) { return model_->term(g).named(); });
    for (std::size_t i = 0; !exact && i < choice_.chosen.size(); ++i) {
      const Term& t = term(i);
      const bool table = model_->is_table(choice_.chosen[i]);
      if (!table && !t.harmonic && !t.reshaped && !t.hysteresis && !t.step && t.named()) continue;
      const double size = standard_deviation(added(i));
      // A step is what it is: of any size, named or not.
      const bool coarse = table || (incomplete && !t.named() && !t.step);
      const double part = t.hysteresis && t.shapes ? material_part_of_coasting : material_part;
      worth = std::max(worth, (coarse ? material_part_of_table : part) * size);
      if (!table) of_shapes = std::max(of_shapes, part * size);
    }
    const bool changed = std::abs(worth - history_.worth) > 0.2 * history_.worth;
    history_.worth = worth, history_.worth_of_shapes = of_shapes;
    return changed;
  }

  /// Scans the residual; at first also the error itself, in which terms that imitate an event do not hide it.
  /// Tables are left out, which would absorb what a scan is to find.
  bool scan(bool first) {
    const bool any = first && scan_residual(*model_, model_->residual({}, model_->fit({})), scanned_);
    // A scan does not depend on the mean.
    const auto is_constant = [&](std::size_t g) { return model_->term(g).constant; };
    if (first && std::all_of(choice_.chosen.begin(), choice_.chosen.end(), is_constant)) return any;
    LinearModel::Set curves;
    for (const std::size_t g : choice_.chosen)
      if (!model_->is_table(g)) curves.push_back(g);
    const bool beside = scan_residual(*model_, model_->residual(curves, model_->fit(curves)), scanned_);
    return scan_beside_names() || beside || any;
  }

  /// One transition that lasts stands for several steps, and hides those that have not been found: what the
  /// names leave has them.
  bool scan_beside_names() {
    if (std::ranges::none_of(choice_.chosen, [&](std::size_t g) { return model_->is_transition(g); }))
      return false;
    return scan_events(*model_, model_->residual(choice_.named, model_->fit(choice_.named)), scanned_);
  }

  /// Orders whose whole number the record does not establish are named no more: they are free ones.
  void free_orders() {
    const std::vector<Scanned::Rate> rates = without_whole_number(*model_, choice_);
    if (rates.empty()) return;
    for (const Scanned::Rate& r : rates) {
      std::erase_if(scanned_.orders, [&](const Scanned::Rate& known) { return known.value == r.value; });
      scanned_.orders.push_back(r);
      history_.refuted.push_back(family_of_order(r.value));
    }
    rebuild();
  }

  /// A curve of the position without a name may be a short part of one period per revolution, if that, of a
  /// possible size, explains everything, the zero included: beside a free one it would stand in for most
  /// curves.
  void admit_arcs() {
    const auto has_curve = [&] {
      return std::any_of(choice_.chosen.begin(), choice_.chosen.end(),
                         [&](std::size_t g) { return model_->candidate(g).family == "position"; });
    };
    if (!has_curve() || !record_.encoder.zero_known) return;
    const Choice before = choice_;
    history_.arcs = true;
    choose();
    bool possible = !has_curve() && model_->is_complete(choice_.chosen);
    for (std::size_t i = 0; i < choice_.chosen.size(); ++i)
      possible &=
          !term(i).constant && (!model_->candidate(choice_.chosen[i]).replaces_only ||
                                has_possible_size(*model_, choice_.chosen[i],
                                                  model_->coefficients(choice_.chosen, choice_.fit, i)));
    if (possible) return;
    choice_ = before;
    history_.arcs = false;
  }

  bool refute(const std::vector<std::string>& refuted) {
    history_.refuted.insert(history_.refuted.end(), refuted.begin(), refuted.end());
    return !refuted.empty();
  }

  const Evidence& record_;
  std::uint64_t seed_;
  ErrorSamples samples_;
  Dictionary dictionary_;
  Scanned scanned_;
  ChoiceHistory history_;
  std::vector<std::string> families_;  ///< of the previous pass's choice
  std::vector<Addition> displacing_;   ///< what displaces the position on which others depend
  ExcessVariance excess_;
  std::optional<ErrorModel> model_;
  Choice choice_;
};

}  // namespace

FoundCauses search_causes(const Evidence& record, std::uint64_t seed, bool with_names) {
  return CauseSearch(record, seed, with_names).found();
}

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

/// Whether a candidate can stand in the place of a chosen term: of another effect or order, and of no family
/// of the other chosen ones.
bool may_replace(const ErrorModel& m, const Choice& choice, std::size_t i, std::size_t candidate) {
  const Candidate& c = m.candidate(candidate);
  const std::size_t replaced = choice.chosen[i];
  if (!c.term->named() || same_term_type(*c.term, m.term(replaced))) return false;
  return std::none_of(choice.chosen.begin(), choice.chosen.end(),
                      [&](std::size_t g) { return g != replaced && m.candidate(g).family == c.family; });
}

/// Whether a candidate needs no more than the terms that it replaces: of its coefficients, of the size that
/// they have, the record determines no more than those have. More would have met by chance.
/// @param others  the chosen terms but those that it replaces
bool is_as_simple(const ErrorModel& m, const Choice& choice, const LinearModel::Set& others,
                  std::size_t candidate, const Eigen::VectorXd& coefficients) {
  Eigen::Index count = 0;
  for (const std::size_t g : choice.chosen)
    if (std::find(others.begin(), others.end(), g) == others.end()) count += m.group(g).count;
  const Eigen::ArrayXd determined =
      m.linear().information(m.groups(), others, candidate).array() * coefficients.squaredNorm();
  return (determined > indistinguishable * m.scale(choice)).count() <= count;
}

/// Whether less than half a period of an order is what terms imitate. With its amplitude and phase free it
/// would stand in for most curves: it must be of a possible size, and as simple.
bool is_imitated(const ErrorModel& m, const Choice& choice, const LinearModel::Set& others, std::size_t arc,
                 const Eigen::VectorXd& coefficients) {
  return has_possible_size(m, arc, coefficients) && is_as_simple(m, choice, others, arc, coefficients);
}

LinearModel::Set without(LinearModel::Set set, std::size_t position) {
  set.erase(set.begin() + static_cast<std::ptrdiff_t>(position));
  return set;
}

/// Weighted sum of squares that a choice leaves with a non-linear term, about its own parameters, in the
/// place of one of its members.
/// @param p  parameters to start from
double left_by_nonlinear(const ErrorModel& m, const LinearModel::Set& others, const Term& original,
                         Eigen::VectorXd p) {
  constexpr int steps = 6;
  const Eigen::MatrixXd beside = m.columns(others);
  double left = std::numeric_limits<double>::infinity();
  for (int step = 0; step < steps; ++step) {
    const Term t = original.relinearized(m.sampled(), original, p);
    Eigen::MatrixXd columns(beside.rows(), beside.cols() + t.size());
    columns << beside, t.columns.matrix();
    Eigen::VectorXd error = m.samples().error.matrix();
    if (t.fixed.size() > 0) error -= t.fixed.matrix();
    const LinearModel::Fit f = LinearModel(columns, error, m.weight().matrix(), columns.cols()).fit({}, {});
    if (!f.coefficients.allFinite()) break;
    left = f.rss;
    p = f.coefficients.tail(t.size());
  }
  return left;
}

/// Named terms that could replace a chosen one: the criterion hardly rises, or what is lost is a small part
/// of what the term explains.
void find_replacements(const ErrorModel& m, const Choice& choice, std::size_t i, FoundCauses& result) {
  LinearModel::Set other = choice.chosen;
  const LinearModel::Set others = without(choice.chosen, i);
  const bool complete = m.is_complete(choice.chosen);
  const double lost = m.lost_without(choice, i), hardly = indistinguishable * m.scale(choice);
  for (std::size_t g = 0; g < m.candidates().size(); ++g) {
    if (!may_replace(m, choice, i, g)) continue;
    other[i] = g;
    LinearModel::Fit f = m.fit(other);
    const Eigen::VectorXd own = m.coefficients(other, f, i);
    // Where everything is explained, coefficients that the record does not determine are no objection.
    if (!f.regular) f.regular = complete && is_as_simple(m, choice, others, g, own);
    if (!m.possible(other, f)) continue;
    const bool arc = m.periods(g) < distinct_periods;
    // A zero's error is constant, as the top of any wave is over a short way.
    if (arc && m.term(choice.chosen[i]).constant) continue;
    if (arc && !(complete && is_imitated(m, choice, others, g, own))) continue;
    double left = f.rss - choice.fit.rss;
    const double least = m.group(g).least_gain;
    if (complete && left > hardly && m.term(g).relinearized) {
      const Term original = m.candidate(g).over(m.samples().sampling);
      left =
          std::min(left, left_by_nonlinear(m, others, original, own.head(original.size())) - choice.fit.rss);
    }
    // Where everything is explained, a small part that the other leaves of a small error is evidence
    // against it; of a large error, it may be the idealization of its shape.
    const bool near = !arc && left < (1 - alternative_share) * lost &&
                      (!complete || (left < 2 * least && lost > 2 * least / (1 - alternative_share)));
    if (left < hardly || near) result.replacements.push_back({result.chosen.size(), m.candidate(g)});
  }
}

/// Parts of a period that two chosen terms imitate together. An order of which the record covers more would
/// have been chosen, having fewer coefficients.
/// @param places  of the choice's members in the result
void find_imitated(const ErrorModel& m, const Choice& choice, const std::vector<std::size_t>& places,
                   FoundCauses& result) {
  const LinearModel::Set& chosen = choice.chosen;
  if (!m.is_complete(chosen)) return;
  for (std::size_t j = 1; j < chosen.size(); ++j)
    for (std::size_t i = 0; i < j; ++i) {
      if (!m.term(chosen[i]).named() || !m.term(chosen[j]).named()) continue;
      const LinearModel::Set others = without(without(chosen, j), i);
      for (std::size_t g = 0; g < m.candidates().size(); ++g) {
        if (!(m.periods(g) < distinct_periods) || !may_replace(m, choice, i, g)) continue;
        LinearModel::Set other = others;
        other.push_back(g);
        const LinearModel::Fit f = m.fit(other);
        if (f.rss - choice.fit.rss < indistinguishable * m.scale(choice) && m.possible(other, f) &&
            is_imitated(m, choice, others, g, m.coefficients(other, f, others.size())))
          for (const std::size_t k : {i, j}) result.replacements.push_back({places[k], m.candidate(g)});
      }
    }
}

ChosenTerm chosen_term(const ErrorModel& m, const Choice& choice, std::size_t i) {
  const double lost = m.lost_without(choice, i), independent = m.rows() / choice.correlation;
  const double free = std::max(1.0, independent - static_cast<double>(choice.fit.coefficients.size()));
  ChosenTerm c{m.candidate(choice.chosen[i]), m.coefficients(choice.chosen, choice.fit, i)};
  const auto d = static_cast<double>(c.candidate.term->size());
  c.p_value = std::min(1.0, fisher_f_tail(lost / d / m.scale(choice), d, free) * c.candidate.alternatives *
                                static_cast<double>(m.candidates().size()));
  c.lost = lost / m.weight().sum();
  const Eigen::ArrayXd added = addition(*c.candidate.term, c.coefficients);
  c.rms = c.candidate.term->constant ? std::abs(added.mean()) : standard_deviation(added);
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
    // Where the interval holds half of what is between two whole numbers, one within half of it is the
    // likelier; where it holds more than one, none is established.
    const double within = (4 * error < 0.25 ? 4 : 2) * error + 0.02;
    if (std::abs(counts - std::round(counts)) < within && std::round(counts) != 0 && 4 * error < 0.5)
      continue;
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
  std::vector<std::size_t> places(order.size());
  for (const std::size_t i : order) {
    if (m.term(choice.chosen[i]).named()) find_replacements(m, choice, i, result);
    places[i] = result.chosen.size();
    result.chosen.push_back(chosen_term(m, choice, i));
  }
  find_imitated(m, choice, places, result);
  return result;
}

namespace {

/// Why a record does not show an effect that its encoder can have.
std::string hidden_by(const EffectKind& kind, const Evidence& e) {
  if (kind.missing_signal)
    if (const auto missing = kind.missing_signal(e); missing && missing->effect == kind.name)
      return "not recorded: " + missing->needs;
  if (e.is_stationary()) return "standstill";
  if (!e.ordered) return "poses without order in time";
  if ((e.direction.abs() == 1).any() && (e.direction.minCoeff() > -1 || e.direction.maxCoeff() < 1))
    return "motion in one direction";
  return e.range() < 2 * std::numbers::pi ? "less than a turn"
                                          : "proportional to other errors in this motion";
}

/// The parameter that a term's size sets, and its value.
void set_smallest(VisibleEffect& v, const Term& t, double size) {
  Effect filled = t.effect;
  t.fill(filled, size * Eigen::VectorXd::Unit(t.size(), 0));
  for (const auto& [name, value] : filled.numbers)
    if (!t.effect.numbers.contains(name) || t.effect.numbers.at(name) != value)
      if (value != 0 && v.parameter.empty()) v.parameter = name, v.smallest = std::abs(value);
}

bool suits(const EffectKind& kind, const Encoder& encoder) {
  return !kind.encoder_need || (encoder.counts_per_period >= kind.encoder_need->least &&
                                encoder.counts_per_period <= kind.encoder_need->most);
}

}  // namespace

std::vector<VisibleEffect> visible_effects(const ErrorModel& m, const Choice& choice) {
  std::vector<VisibleEffect> visible;
  const double noise = m.scale(choice);
  for (const EffectKind& kind : effect_kinds()) {
    if (!kind.terms || !suits(kind, m.sampled().encoder)) continue;
    const auto of_kind = [&](std::size_t g) { return m.term(g).effect.type == kind.name; };
    if (std::any_of(choice.chosen.begin(), choice.chosen.end(), of_kind)) continue;
    VisibleEffect v{std::string(kind.name), {}, 0, {}};
    for (std::size_t g = 0; g < m.candidates().size() && v.smallest == 0; ++g) {
      if (!of_kind(g) || m.candidate(g).most > 0 || m.candidate(g).replaces_only) continue;
      const double information = m.linear().least_information(m.groups(), choice.chosen, g);
      if (information > 0)
        set_smallest(v, m.term(g),
                     std::sqrt((m.group(g).least_gain + m.group(g).price * noise) / information));
    }
    const auto terms = kind.terms(m.sampled());
    const bool told_by_record =
        !terms.empty() && std::ranges::all_of(terms, [](const Term& t) { return t.shapes != nullptr; });
    if (v.smallest == 0 && told_by_record) continue;  // of its parameters the record has none
    if (v.smallest == 0) v.hidden_by = hidden_by(kind, m.sampled());
    visible.push_back(std::move(v));
  }
  return visible;
}

}  // namespace qerr
