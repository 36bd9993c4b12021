#include "diagnose/search/cause_search.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include "core/probability.hpp"
#include "core/random.hpp"
#include "core/statistics.hpp"
#include "diagnose/search/linear_model.hpp"
#include "diagnose/search/peaks.hpp"
#include "diagnose/terms/unnamed_terms.hpp"
#include "effect/effects/effects.hpp"
#include "qerr/effect/effect_kind.hpp"

namespace qerr {

namespace {

constexpr Eigen::Index most_samples = 6000;
constexpr int most_passes = 7, most_events = 4;

/// The same of a table or polynomial, which follows a curve that is not its own only coarsely, and of any
/// uncatalogued term of a model that does not explain everything.
constexpr double material_part_of_table = 0.2;

/// Ratio of a residual to that of rounding and noise up to which nothing worth mentioning is left.
constexpr double complete = 1.3;

/// Part of what all terms explain that the leading names must reach to come first, and what makes a leading
/// name.
constexpr double named_share = 0.8, leading_part = 0.05;

/// Part of what a term explains that another one must reach to be its alternative: real errors differ from
/// the textbook's shapes by some percent.
constexpr double alternative_share = 0.92;

/// Simulations of a term's null hypothesis, and the error rate of the test.
constexpr int veto_draws = 9;
constexpr double refuted = 0.01;

/// The variance of the samples is known from quantization and noise; a remainder may be this much below it by
/// chance and by the correlation of the roundings.
constexpr double least_variance = 0.9;

/// Smallest error worth a term [counts, rms]: it raises the rms of the quantization error, 1/sqrt(12), by 6
/// %.
constexpr double material = 0.1;

/// The same as a part of the largest error whose shape is an idealization: no gear has exact sines.
constexpr double material_part = 0.012;

/// Whether a term displaces the position on which the errors of gear teeth and disc depend.
bool acts_before_teeth(const Term& t) {
  if (!t.named()) return false;
  const EffectKind& kind = effect_kind(t.effect.type);
  return kind.stage < Stage::gear || kind.first_in_stage;
}

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

class CauseSearch {
 public:
  CauseSearch(const Evidence& record, std::uint64_t seed)
      : record_(record), seed_(seed), samples_(error_samples(record, seed, most_samples)) {}

  FoundCauses found() {
    FoundCauses result;
    if (samples_.size() < 8) return result;
    worth_ = worth_of_shapes_ = material * record_.step();
    for (int pass = 0; pass < most_passes; ++pass) {
      assemble();
      choose();
      if (!learn(pass)) break;
    }
    while (veto()) choose();
    report(result);
    return result;
  }

 private:
  const Evidence& few() const { return samples_.sampling.evidence; }

  void assemble() {
    candidates_ = dictionary(samples_.sampling, scanned_, moved_);
    base_ = record_.encoder.zero_known ? 0 : 1;
    Eigen::Index count = base_;
    groups_.clear();
    std::vector<std::string> families;
    for (const Candidate& c : candidates_) {
      ColumnGroup g;
      g.first = count, g.count = c.term.size();
      g.positive = c.term.positive, g.least = c.least, g.most = c.most;
      const auto known = std::find(families.begin(), families.end(), c.family);
      g.family = static_cast<int>(known - families.begin());
      if (known == families.end()) families.push_back(c.family);
      groups_.push_back(g);
      count += g.count;
    }
    columns_.resize(samples_.size(), count);
    columns_.leftCols(base_).setOnes();
    for (std::size_t i = 0; i < candidates_.size(); ++i)
      columns_.middleCols(groups_[i].first, groups_[i].count) = candidates_[i].term.columns.matrix();
    // What is too small to be worth a term is variance.
    const double unmodelled = std::max(extra_, std::pow(material * record_.step(), 2));
    weight_ = (samples_.variance + unmodelled).inverse();
    // A sample that a step divides belongs to neither side.
    const double interval =
        few().ordered ? few().time[few().rows() - 1] / static_cast<double>(record_.rows()) : 0;
    for (const Event& event : scanned_.events)
      weight_ = ((few().time - event.time).abs() < 2 * interval).select(0.0, weight_);
    // Nor does one at which the side of a play is unknown.
    if (few().ordered && (few().direction.abs() == 1).any())
      weight_ = (few().direction.abs() == 1).select(weight_, 0.0);
    model_.emplace(columns_, samples_.error.matrix(), weight_.matrix(), base_);
    floor_ = least_variance * (samples_.variance * weight_).sum() / model_->rows();
  }

  /// Schwarz's price of the coefficients, that of the number of alternatives, and what makes a term material:
  /// a decrease of the mean square by the square of what is worth a term.
  /// @param worth  of names, which beside a table must be larger
  void price(double independent, double worth) {
    const double least = worth * worth * weight_.sum(),
                 other = worth_of_shapes_ * worth_of_shapes_ * weight_.sum();
    // A shape that the catalogue does not have must be better than a named one by what is material, and a
    // table better than as many sines as have its number of coefficients.
    for (std::size_t i = 0; i < groups_.size(); ++i) {
      const auto count = static_cast<double>(groups_[i].count);
      groups_[i].price = count * std::log(std::max(independent, 2.0)) +
                         2 * std::log(std::max(1.0, candidates_[i].alternatives));
      groups_[i].least_gain = is_table(i)                   ? std::max(2.0, 0.5 * count) * other
                              : candidates_[i].term.named() ? least
                                                            : 2 * other;
    }
  }

  /// Tables and polynomials.
  bool is_table(std::size_t candidate) const {
    return candidates_[candidate].family == "time" || candidates_[candidate].family == "position";
  }

  bool raise_worth() {
    double worth = material * record_.step(), of_shapes = worth;
    const bool incomplete = !is_complete(chosen_);
    for (std::size_t i = 0; i < chosen_.size(); ++i) {
      const Term& t = term(i);
      const bool table = is_table(chosen_[i]);
      if (!table && !t.harmonic && !t.reshaped && !t.hysteresis && !t.step && t.named()) continue;
      const double size = standard_deviation(addition(t, coefficients(i)));
      const bool coarse = table || (incomplete && !t.named());
      worth = std::max(worth, (coarse ? material_part_of_table : material_part) * size);
      if (!table) of_shapes = std::max(of_shapes, material_part * size);
    }
    const bool changed = std::abs(worth - worth_) > 0.2 * worth_;
    worth_ = worth, worth_of_shapes_ = of_shapes;
    return changed;
  }

  Eigen::ArrayXd residual_of(const LinearModel::Set& set, const LinearModel::Fit& f) const {
    Eigen::VectorXd r = samples_.error.matrix();
    r -= columns_.leftCols(base_) * f.coefficients.head(base_);
    Eigen::Index at = base_;
    for (const std::size_t g : set) {
      r -= columns_.middleCols(groups_[g].first, groups_[g].count) *
           f.coefficients.segment(at, groups_[g].count);
      at += groups_[g].count;
    }
    return r.array();
  }

  /// Searches twice: the first time as if all samples were independent, for the residual of the richest
  /// model, whose autocorrelation gives the number of independent samples.
  void choose() {
    const double rows = model_->rows();
    richest_ = best_of_starts(rows);
    const LinearModel::Set& richest = richest_;
    const Eigen::ArrayXd residual = residual_of(richest, model_->fit(groups_, richest)) * weight_.sqrt();
    correlation_ = few().ordered ? integrated_correlation(residual) : 1;
    if (!few().ordered || correlation_ < 1.5) {
      chosen_ = richest;
    } else {
      chosen_ = best_of_starts(rows / correlation_);
    }
    fit_ = model_->fit(groups_, chosen_);
    residual_ = residual_of(chosen_, fit_);
    found_before_.clear();
    for (const std::size_t g : richest_) found_before_.push_back(candidates_[g].family);
  }

  /// The best of the sets that the search reaches from nothing, from the best named terms and from what the
  /// previous pass has found: a table can take the place of any one of several named terms that together need
  /// fewer coefficients.
  LinearModel::Set best_of_starts(double independent) {
    const auto search = [&](const LinearModel::Set& start, std::size_t locked) {
      return model_->search(groups_, start, locked, independent, floor_);
    };
    const auto value = [&](const LinearModel::Set& s) {
      return model_->criterion(groups_, s, model_->fit(groups_, s).rss, independent, floor_);
    };
    const auto better = [&](LinearModel::Set a, LinearModel::Set b) { return value(a) <= value(b) ? a : b; };
    price(independent, worth_of_shapes_);
    allow([&](std::size_t i) { return candidates_[i].term.named(); });
    const LinearModel::Set names = better(search(previous(), 0), search({}, 0));
    price(independent, worth_);
    allow([](std::size_t) { return true; });
    LinearModel::Set best = better(search(names, 0), search({}, 0));
    if (!found_before_.empty()) best = better(std::move(best), search(previous(), 0));
    if (is_complete(best)) return best;
    const LinearModel::Set core = leading_names(names, best);
    if (core.empty()) return best;
    price(independent, worth_of_shapes_);
    return search(core, core.size());
  }

  /// The names that come first where nothing explains everything: those that explain a twentieth of what
  /// names can explain, if they are few and explain nearly as much as the best model. Real errors differ from
  /// the textbook's shapes, and a table of any curve fits better than a name; but it tells nothing.
  LinearModel::Set leading_names(const LinearModel::Set& names, const LinearModel::Set& best) const {
    const double nothing = model_->fit(groups_, {}).rss, with_names = model_->fit(groups_, names).rss,
                 all = nothing - model_->fit(groups_, best).rss;
    LinearModel::Set core;
    for (std::size_t i = 0; i < names.size(); ++i) {
      // Steps and exponentials are functions of time alone, of which a table is only the better version.
      const Term& t = candidates_[names[i]].term;
      if (t.step || t.reshaped) continue;
      LinearModel::Set without = names;
      without.erase(without.begin() + static_cast<std::ptrdiff_t>(i));
      if (model_->fit(groups_, without).rss - with_names > leading_part * (nothing - with_names))
        core.push_back(names[i]);
    }
    const double explained = nothing - model_->fit(groups_, core).rss;
    if (explained < named_share * all || count_causes(core) > best.size()) return {};
    return core;
  }

  /// Number of causes, of which all orders of a shaft are one.
  std::size_t count_causes(const LinearModel::Set& set) const {
    std::vector<std::string> causes;
    std::size_t steps = 0;
    for (const std::size_t g : set) {
      const Term& t = candidates_[g].term;
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

  template <typename Which>
  void allow(Which which) {
    for (std::size_t i = 0; i < groups_.size(); ++i) groups_[i].allowed = which(i) && !is_banned(i);
  }

  /// The allowed groups of the families that the previous pass has found.
  LinearModel::Set previous() const {
    LinearModel::Set set;
    for (const std::string& family : found_before_)
      for (std::size_t i = 0; i < candidates_.size(); ++i)
        if (candidates_[i].family == family && groups_[i].allowed) {
          set.push_back(i);
          break;
        }
    return model_->possible(groups_, set, model_->fit(groups_, set)) ? set : LinearModel::Set{};
  }

  /// Whether a model leaves no more than `complete` times what rounding and noise leave in the readings.
  bool is_complete(const LinearModel::Set& set) const {
    const Eigen::ArrayXd left = residual_of(set, model_->fit(groups_, set));
    const double rounding = record_.step() * record_.step() / 12 + record_.path_noise * record_.path_noise;
    const double excess = mean_of_used(left.square() - samples_.variance);
    return excess < (complete * complete - 1) * rounding;
  }

  /// Mean over the samples that have a weight.
  double mean_of_used(const Eigen::ArrayXd& x) const {
    return (weight_ > 0).select(x, 0.0).sum() / model_->rows();
  }

  bool is_banned(std::size_t candidate) const {
    return std::find(banned_.begin(), banned_.end(), candidates_[candidate].family) != banned_.end();
  }

  Eigen::VectorXd coefficients(std::size_t position) const {
    Eigen::Index at = base_;
    for (std::size_t i = 0; i < position; ++i) at += groups_[chosen_[i]].count;
    return fit_.coefficients.segment(at, groups_[chosen_[position]].count);
  }

  const Term& term(std::size_t position) const { return candidates_[chosen_[position]].term; }

  /// Updates what the next pass depends on.
  /// @returns whether anything changed
  bool learn(int pass) {
    bool changed = displace();
    changed |= reweigh();
    changed |= raise_worth();
    changed |= refine();
    // Once a scan has added nothing to the model, another one would only find the same.
    std::vector<std::string> families;
    for (const std::size_t g : chosen_) families.push_back(candidates_[g].family);
    std::sort(families.begin(), families.end());
    if (pass == 0 || families != families_) changed |= scan(pass == 0);
    families_ = std::move(families);
    return changed;
  }

  bool displace() {
    Eigen::ArrayXd moved = Eigen::ArrayXd::Zero(samples_.size());
    for (std::size_t i = 0; i < chosen_.size(); ++i)
      if (acts_before_teeth(term(i)) && !term(i).constant) moved += addition(term(i), coefficients(i));
    const Eigen::ArrayXd before = moved_.size() > 0 ? moved_ : Eigen::ArrayXd::Zero(samples_.size());
    const bool changed = (moved - before).abs().maxCoeff() > 2 * record_.step();
    if (changed) moved_ = std::move(moved);
    return changed;
  }

  /// What is left beyond the stated variance has one more variance, the same in every row.
  bool reweigh() {
    const double free = static_cast<double>(fit_.coefficients.size());
    const double excess = mean_of_used(residual_.square() - samples_.variance) * model_->rows() /
                          std::max(1.0, model_->rows() - free);
    const double now = std::max(0.0, excess), scale = now + mean_of_used(samples_.variance);
    const bool changed = std::abs(now - extra_) > 0.1 * scale;
    extra_ = now;
    return changed;
  }

  /// Gauss-Newton step of all shapes at once: a column for the derivative of each.
  bool refine() {
    std::vector<std::size_t> shaped;
    for (std::size_t i = 0; i < chosen_.size(); ++i)
      if (term(i).reshaped) shaped.push_back(i);
    Scanned next = scanned_;
    next.orders.clear(), next.loaded_orders.clear(), next.lines.clear(), next.time_constants.clear(),
        next.hystereses.clear();
    next.events.clear(), next.places.clear();
    bool changed = false;
    if (!shaped.empty()) {
      Eigen::Index count = fit_.coefficients.size();
      Eigen::MatrixXd columns(samples_.size(), count + static_cast<Eigen::Index>(shaped.size()));
      columns.leftCols(base_) = columns_.leftCols(base_);
      Eigen::Index at = base_;
      for (const std::size_t g : chosen_) {
        columns.middleCols(at, groups_[g].count) = columns_.middleCols(groups_[g].first, groups_[g].count);
        at += groups_[g].count;
      }
      for (std::size_t s = 0; s < shaped.size(); ++s) {
        const Term& t = term(shaped[s]);
        const double by = 1e-3 * t.half_width;
        const Eigen::ArrayXXd change =
            t.reshaped(few(), t, t.shape + by).columns - t.reshaped(few(), t, t.shape - by).columns;
        columns.col(count + static_cast<Eigen::Index>(s)) =
            change.matrix() * coefficients(shaped[s]) / (2 * by);
      }
      const LinearModel linear(columns, samples_.error.matrix(), weight_.matrix(), columns.cols());
      const LinearModel::Fit f = linear.fit({}, {});
      for (std::size_t s = 0; s < shaped.size(); ++s) {
        const Term& t = term(shaped[s]);
        const double by = std::clamp(f.coefficients[count + static_cast<Eigen::Index>(s)],
                                     -0.5 * t.half_width, 0.5 * t.half_width);
        const double shape = t.shape + (std::isfinite(by) ? by : 0.0);
        changed |= std::abs(by) > 0.02 * t.half_width;
        keep_shape(t, shape, next);
      }
    }
    for (std::size_t i = 0; i < chosen_.size(); ++i) keep_size(i, next, changed);
    for (const LinearModel::Set* set : {&chosen_, &richest_})
      for (const std::size_t g : *set) keep(candidates_[g], next);
    scanned_ = std::move(next);
    return changed;
  }

  void keep_shape(const Term& t, double shape, Scanned& next) const {
    if (t.pattern == Shape::line)
      next.lines.push_back({shape, hypotheses_of(scanned_.lines, t.shape)});
    else if (t.harmonic)
      next.orders.push_back({shape, hypotheses_of(scanned_.orders, t.shape)});
    else
      next.time_constants.push_back(std::max(shape, 0.1 * t.shape));
  }

  static double hypotheses_of(const std::vector<Scanned::Rate>& rates, double value) {
    for (const Scanned::Rate& r : rates)
      if (r.value == value) return r.hypotheses;
    return rates.empty() ? 1 : rates.front().hypotheses;
  }

  /// Parameters of a non-linear term by Gauss-Newton steps on the error that the other named terms leave.
  Eigen::VectorXd parameters_of_linearization(std::size_t i) const {
    constexpr int steps = 6;
    const Term original = candidates_[chosen_[i]].over(samples_.sampling);
    Eigen::VectorXd p = coefficients(i).head(original.size());
    Eigen::ArrayXd target = residual_;
    for (std::size_t k = 0; k < chosen_.size(); ++k)
      if (k == i || !term(k).named()) target += addition(term(k), coefficients(k));
    for (int step = 0; step < steps; ++step) {
      const Term t = original.relinearized(few(), original, p);
      Eigen::MatrixXd columns(samples_.size(), t.size() + 1);
      columns << Eigen::VectorXd::Ones(samples_.size()), t.columns.matrix();
      Eigen::VectorXd left = target.matrix();
      if (t.fixed.size() > 0) left -= t.fixed.matrix();
      const LinearModel linear(columns, left, weight_.matrix(), columns.cols());
      const Eigen::VectorXd next = linear.fit({}, {}).coefficients.tail(t.size());
      if (!next.allFinite()) break;
      p = next;
    }
    return p;
  }

  /// Keeps the size of a chosen hysteresis, and the parameters of a chosen linearization.
  void keep_size(std::size_t i, Scanned& next, bool& changed) const {
    if (term(i).relinearized) {
      const Eigen::VectorXd p = parameters_of_linearization(i);
      changed |= scanned_.linearizations.empty() ||
                 (p - scanned_.linearizations.front()).norm() > 0.01 * p.norm() ||
                 p.size() != scanned_.linearizations.front().size();
      next.linearizations.push_back(p);
    }
    if (!term(i).hysteresis) return;
    const double size = coefficients(i)[0];
    changed |= scanned_.hystereses.empty() || std::abs(size - scanned_.hystereses.front()) > 0.02 * size;
    next.hystereses.push_back(size);
  }

  /// Keeps what a term of a scan needs to be found again.
  void keep(const Candidate& c, Scanned& next) const {
    const Term& t = c.term;
    const auto add = [](auto& list, const auto& item, auto value) {
      if (std::none_of(list.begin(), list.end(),
                       [&](const auto& other) { return value(other) == value(item); }))
        list.push_back(item);
    };
    const auto rate = [](const Scanned::Rate& r) { return r.value; };
    if (t.harmonic && t.named())
      add(next.orders, Scanned::Rate{std::abs(wave_number(t.effect, few().encoder)), 1, true}, rate);
    else if (t.harmonic && !refined_now(t, next.orders))
      add(next.orders, Scanned::Rate{t.shape, hypotheses_of(scanned_.orders, t.shape)}, rate);
    else if (t.pattern == Shape::line && !refined_now(t, next.lines))
      add(next.lines, Scanned::Rate{t.shape, hypotheses_of(scanned_.lines, t.shape)}, rate);
    else if (c.family.rfind("loaded order", 0) == 0)
      add(next.loaded_orders,
          Scanned::Rate{t.effect.number_or("order", 0),
                        hypotheses_of(scanned_.loaded_orders, t.effect.number_or("order", 0))},
          rate);
    else if (c.family.rfind("event", 0) == 0)
      add(next.events, scanned_.events[c.scanned], [](const Event& e) { return e.time; });
    else if (c.family.rfind("bump", 0) == 0)
      add(next.places, scanned_.places[c.scanned], [](const Bump& p) { return p.position; });
  }

  /// Whether a rate was already kept at its refined value.
  static bool refined_now(const Term& t, const std::vector<Scanned::Rate>& rates) {
    return std::any_of(rates.begin(), rates.end(),
                       [&](const Scanned::Rate& r) { return std::abs(r.value - t.shape) <= t.half_width; });
  }

  /// Residual of the chosen terms without tables, which would absorb what a scan is to find.
  Eigen::ArrayXd residual_without_tables() const {
    LinearModel::Set set;
    for (const std::size_t g : chosen_)
      if (!is_table(g)) set.push_back(g);
    return residual_of(set, model_->fit(groups_, set));
  }

  /// Scans the residual; at first also the error itself, in which terms that imitate an event do not hide it.
  bool scan(bool first) {
    bool any = first && scan(residual_of({}, model_->fit(groups_, {})));
    if (!first || !chosen_.empty()) any |= scan(set_has_tables() ? residual_without_tables() : residual_);
    return any;
  }

  bool scan(const Eigen::ArrayXd& residual) {
    const Eigen::ArrayXd scores = (residual - (residual * weight_).sum() / weight_.sum()) * weight_;
    bool any = false;
    if (!few().is_stationary()) any |= scan_orders(scores, scanned_.orders, 5);
    if (!few().is_stationary() && few().effort.size() > 0)
      any |= scan_orders(scores * (few().effort / std::max(1e-300, few().effort.abs().maxCoeff())),
                         scanned_.loaded_orders, 2);
    if (few().ordered) any |= scan_time(residual, scores);
    if (!few().is_stationary()) any |= scan_places(residual);
    return any;
  }

  bool set_has_tables() const {
    return std::any_of(chosen_.begin(), chosen_.end(), [&](std::size_t g) { return is_table(g); });
  }

  bool scan_orders(const Eigen::ArrayXd& scores, std::vector<Scanned::Rate>& known, Eigen::Index most) {
    const double range = few().range();
    RateScan s{1.5 * 2 * std::numbers::pi / range, highest_order(), most};
    double hypotheses = 1;
    bool any = false;
    for (const double rate : strongest_rates(scores, few().path, s, hypotheses)) {
      const double resolution = 0.5 * std::numbers::pi / range;
      if (gain_of(free_order_term(few(), rate), scores) < 2 * std::log(hypotheses)) break;
      if (std::any_of(known.begin(), known.end(),
                      [&](const Scanned::Rate& r) { return std::abs(r.value - rate) < resolution; }))
        continue;
      known.push_back({rate, hypotheses});
      any = true;
    }
    return any;
  }

  /// The order that the motion still resolves: a period of four counts, and two rows a period in nine tenths
  /// of the motion. At a constant speed an order beyond that is the alias of another.
  double highest_order() const {
    const double of_counts = 0.5 * std::numbers::pi / record_.step();
    if (!few().ordered || record_.rows() < 3) return of_counts;
    const Eigen::Index n = record_.rows() - 1, stride = std::max<Eigen::Index>(1, n / 20000);
    std::vector<double> moved;
    for (Eigen::Index k = 0; k < n; k += stride)
      if (const double by = std::abs(record_.path[k + 1] - record_.path[k]); by > 4 * record_.path_noise)
        moved.push_back(by);
    if (moved.size() < 20) return of_counts;
    const auto tenth = moved.begin() + static_cast<std::ptrdiff_t>(moved.size() / 10);
    std::nth_element(moved.begin(), tenth, moved.end());
    return std::min(of_counts, std::numbers::pi / *tenth);
  }

  /// Decrease of the weighted sum of squares by a term alone.
  double gain_of(const Term& t, const Eigen::ArrayXd& scores) const {
    double gain = 0;
    for (Eigen::Index i = 0; i < t.size(); ++i) {
      const auto column = t.columns.col(i);
      gain += std::pow((column * scores).sum(), 2) / std::max((column.square() * weight_).sum(), 1e-300);
    }
    return gain;
  }

  bool scan_time(const Eigen::ArrayXd& residual, const Eigen::ArrayXd& scores) {
    bool any = false;
    const double duration = few().time[few().rows() - 1];
    if (!(duration > 0)) return false;
    const double interval = duration / static_cast<double>(record_.rows());
    RateScan s{2 * std::numbers::pi * 8 / duration, std::numbers::pi / interval, 3};
    double hypotheses = 1;
    for (const double rate : strongest_rates(scores, few().time, s, hypotheses)) {
      const double f = rate / (2 * std::numbers::pi);
      if (std::any_of(scanned_.lines.begin(), scanned_.lines.end(),
                      [&](const Scanned::Rate& r) { return std::abs(r.value - f) < 0.25 / duration; }))
        continue;
      scanned_.lines.push_back({f, hypotheses});
      any = true;
    }
    Eigen::ArrayXd left = residual;
    for (int i = 0; i < most_events; ++i) {
      const Event event = strongest_event(left, weight_, few().time);
      if (event.hypotheses == 0) break;
      const Term t = offset_step_term(few(), event.time);
      const Eigen::ArrayXd step = t.columns.col(0) - (t.columns.col(0) * weight_).sum() / weight_.sum();
      const double size = (step * weight_ * left).sum() / (step.square() * weight_).sum();
      if (size * size * (step.square() * weight_).sum() < 2 * std::log(event.hypotheses)) break;
      left -= size * step;
      if (std::any_of(scanned_.events.begin(), scanned_.events.end(),
                      [&](const Event& e) { return std::abs(e.time - event.time) < 2e-3 * duration; }))
        continue;
      scanned_.events.push_back(event);
      any = true;
    }
    return any;
  }

  bool scan_places(const Eigen::ArrayXd& residual) {
    const Bump b = strongest_bump(residual, weight_, few().path);
    if (b.width == 0 || std::any_of(scanned_.places.begin(), scanned_.places.end(), [&](const Bump& p) {
          return std::abs(p.position - b.position) < b.width;
        }))
      return false;
    scanned_.places.push_back({b.position, b.width, b.hypotheses});
    return true;
  }

  /// Bans the families of terms that the quantizer alone would bring: the fit without the term, sent through
  /// the quantizer along the same path with new noise, is analysed with it. Its decrease of the sum of
  /// squares is an F variable of the veto_draws' mean.
  /// @returns whether any term was banned
  bool veto() {
    bool any = false;
    for (std::size_t i = 0; i < chosen_.size(); ++i) {
      LinearModel::Set without = chosen_;
      without.erase(without.begin() + static_cast<std::ptrdiff_t>(i));
      const LinearModel::Fit rest = model_->fit(groups_, without);
      const double lost = rest.rss - fit_.rss;
      if (lost > weight_.sum() * record_.step() * record_.step()) continue;  // of more than a count
      const double expected = expected_gain(without, rest, chosen_[i]);
      const auto d = static_cast<double>(term(i).size());
      if (fisher_f_tail(lost / std::max(expected, 1e-300), d, veto_draws * d) < refuted) continue;
      banned_.push_back(candidates_[chosen_[i]].family);
      any = true;
    }
    return any;
  }

  /// Mean decrease of the weighted sum of squares by a candidate in simulations of a model without it.
  double expected_gain(const LinearModel::Set& without, const LinearModel::Fit& f, std::size_t extra) const {
    std::vector<RowGroup> rows;
    for (Eigen::Index k = 0; k < record_.rows(); ++k) rows.push_back({k, k + 1});
    const Sampling every(record_, std::move(rows));
    Eigen::ArrayXd added = Eigen::ArrayXd::Constant(record_.rows(), base_ > 0 ? f.coefficients[0] : 0);
    Eigen::Index at = base_;
    for (const std::size_t g : without) {
      added += addition(searchable(candidates_[g].over(every)), f.coefficients.segment(at, groups_[g].count));
      at += groups_[g].count;
    }
    double sum = 0;
    for (int draw = 0; draw < veto_draws; ++draw) {
      Evidence simulated = record_;
      const std::uint64_t seed = stream_seed(seed_, "surrogate", static_cast<std::uint64_t>(draw));
      for (Eigen::Index k = 0; k < record_.rows(); ++k)
        simulated.measured[k] =
            quantize(record_.encoder, record_.path[k] + added[k] +
                                          record_.path_noise * normal(seed, static_cast<std::uint64_t>(k)));
      sum += gain_in(simulated, without, extra);
    }
    return sum / veto_draws;
  }

  double gain_in(const Evidence& simulated, const LinearModel::Set& without, std::size_t extra) const {
    const ErrorSamples s = error_samples(simulated, seed_, most_samples);
    std::vector<ColumnGroup> groups;
    Eigen::MatrixXd columns = Eigen::MatrixXd::Ones(s.size(), base_);
    LinearModel::Set all = without;
    all.push_back(extra);
    for (const std::size_t g : all) {
      const Term t = searchable(candidates_[g].over(s.sampling));
      groups.push_back({columns.cols(), t.size(), static_cast<int>(groups.size())});
      columns.conservativeResize(Eigen::NoChange, columns.cols() + t.size());
      columns.rightCols(t.size()) = t.columns.matrix();
    }
    const Eigen::ArrayXd weight =
        (s.variance + std::max(extra_, std::pow(material * record_.step(), 2))).inverse();
    const LinearModel model(columns, s.error.matrix(), weight.matrix(), base_);
    LinearModel::Set rest(without.size());
    for (std::size_t i = 0; i < rest.size(); ++i) rest[i] = i;
    LinearModel::Set with = rest;
    with.push_back(without.size());
    return (model.fit(groups, rest).rss - model.fit(groups, with).rss) * weight_.sum() / weight.sum();
  }

  /// Residual variance per independent sample, in units of the weights.
  double scale() const { return std::max(fit_.rss / model_->rows(), floor_) * correlation_; }

  double lost_without(std::size_t i) const {
    LinearModel::Set without = chosen_;
    without.erase(without.begin() + static_cast<std::ptrdiff_t>(i));
    return std::max(0.0, model_->fit(groups_, without).rss - fit_.rss);
  }

  /// Counts are lost in whole numbers: other steps become uncatalogued ones.
  void distinguish_steps() {
    for (std::size_t i = 0; i < chosen_.size(); ++i) {
      if (!term(i).whole) continue;
      const double counts = coefficients(i)[0];
      const double error = std::abs(counts) * std::sqrt(scale() / std::max(lost_without(i), 1e-300));
      // Edges are displaced by some percent of a count.
      if (std::abs(counts - std::round(counts)) < 4 * error + 0.05 && std::round(counts) != 0) continue;
      for (std::size_t g = 0; g < candidates_.size(); ++g)
        if (candidates_[g].family == candidates_[chosen_[i]].family && candidates_[g].term.step &&
            !candidates_[g].term.named()) {
          chosen_[i] = g;
          break;
        }
    }
    fit_ = model_->fit(groups_, chosen_);
    residual_ = residual_of(chosen_, fit_);
  }

  /// Named terms that could replace a chosen one: the criterion rises by less than the 99.95 % quantile of
  /// chi-squared with one degree of freedom, or what is lost is a small part of what the term explains.
  void find_replacements(std::size_t i, FoundCauses& result, std::size_t number) const {
    constexpr double indistinguishable = 12.1;
    LinearModel::Set other = chosen_;
    const bool complete_fit = is_complete(chosen_);
    const double lost = lost_without(i);
    for (std::size_t g = 0; g < candidates_.size(); ++g) {
      const Candidate& c = candidates_[g];
      if (!c.term.named() || same_term_type(c.term, term(i)) ||
          (c.term.harmonic && periods_covered(c.term, few()) < 0.5) ||
          std::find_if(chosen_.begin(), chosen_.end(), [&](std::size_t m) {
            return m != chosen_[i] && candidates_[m].family == c.family;
          }) != chosen_.end())
        continue;
      other[i] = g;
      const LinearModel::Fit f = model_->fit(groups_, other);
      if (!model_->possible(groups_, other, f)) continue;
      const double variance = std::max(fit_.rss / model_->rows(), floor_) * correlation_;
      const bool likely = (f.rss - fit_.rss) / variance < indistinguishable;
      // Where everything is explained, a small part that the other leaves of a small error is evidence
      // against it; of a large error, it may be the idealization of its shape.
      const double left = f.rss - fit_.rss, least = groups_[g].least_gain;
      const bool near = left < (1 - alternative_share) * lost &&
                        (!complete_fit || (left < 2 * least && lost > 2 * least / (1 - alternative_share)));
      if (!likely && !near) continue;
      result.replacements.push_back({number, c.term.effect});
    }
  }

  static bool same_term_type(const Term& a, const Term& b) {
    return a.effect.type == b.effect.type && a.effect.number_or("order", 0) == b.effect.number_or("order", 0);
  }

  /// Why a record does not show an effect that its encoder can have.
  std::string hidden_by(const EffectKind& kind) const {
    const Evidence& e = few();
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

  /// Size at which a term would have passed the criterion beside what was found.
  void list_visible(FoundCauses& result) const {
    const double noise = std::max(fit_.rss / model_->rows(), floor_) * correlation_;
    for (const EffectKind& kind : effect_kinds()) {
      if (!kind.terms) continue;
      if (kind.encoder_need && (few().encoder.counts_per_period < kind.encoder_need->least ||
                                few().encoder.counts_per_period > kind.encoder_need->most))
        continue;
      const auto of_kind = [&](std::size_t g) { return candidates_[g].term.effect.type == kind.name; };
      if (std::any_of(chosen_.begin(), chosen_.end(), of_kind)) continue;
      VisibleEffect v{std::string(kind.name), {}, 0, {}};
      for (std::size_t g = 0; g < candidates_.size() && v.smallest == 0; ++g) {
        if (!of_kind(g) || candidates_[g].most > 0) continue;
        const Term& t = candidates_[g].term;
        const double information = model_->least_information(groups_, chosen_, g);
        if (information <= 0) continue;
        const double size = std::sqrt((groups_[g].least_gain + groups_[g].price * noise) / information);
        Effect filled = t.effect;
        t.fill(filled, size * Eigen::VectorXd::Unit(t.size(), 0));
        for (const auto& [name, value] : filled.numbers)
          if (!t.effect.numbers.contains(name) || t.effect.numbers.at(name) != value)
            if (value != 0 && v.parameter.empty()) v.parameter = name, v.smallest = std::abs(value);
      }
      if (v.smallest == 0) v.hidden_by = hidden_by(kind);
      result.visible.push_back(std::move(v));
    }
  }

  /// Whether a whole order that a scan has found lies among fractions: these are one order whose amplitude
  /// varies along the path, and one of its sidebands is a whole number by chance. Sidebands are of one size,
  /// within a factor of three.
  bool is_sideband(std::size_t i) const {
    if (!term(i).named() || !term(i).harmonic || candidates_[chosen_[i]].alternatives == 1) return false;
    const double order = std::abs(wave_number(term(i).effect, few().encoder));
    const double near = 6 * 2 * std::numbers::pi / few().range();
    for (std::size_t other = 0; other < chosen_.size(); ++other)
      if (term(other).harmonic && !term(other).named() && std::abs(term(other).shape - order) < near &&
          3 * coefficients(other).norm() > coefficients(i).norm())
        return true;
    return false;
  }

  void report(FoundCauses& result) {
    distinguish_steps();
    const double independent = model_->rows() / correlation_;
    result.samples_per_reading = correlation_;
    const double total_weight = weight_.sum();
    result.excess = extra_;
    result.explained = (model_->fit(groups_, {}).rss - fit_.rss) / total_weight;
    const double free = std::max(1.0, independent - static_cast<double>(fit_.coefficients.size()));
    std::vector<std::size_t> order;
    std::vector<ChosenTerm> found;
    for (std::size_t i = 0; i < chosen_.size(); ++i) {
      const double lost = lost_without(i);
      const auto d = static_cast<double>(term(i).size());
      ChosenTerm c{candidates_[chosen_[i]], coefficients(i)};
      if (is_sideband(i)) {
        const double order = std::abs(wave_number(term(i).effect, few().encoder));
        c.candidate.term = free_order_term(few(), order);
        c.candidate.term.pattern = Shape::order;
        c.candidate.over = [order](const Sampling& s) {
          Term t = free_order_term(s.evidence, order);
          t.pattern = Shape::order;
          return t;
        };
      }
      c.p_value = std::min(1.0, fisher_f_tail(lost / d / scale(), d, free) * c.candidate.alternatives *
                                    static_cast<double>(candidates_.size()));
      c.lost = lost / total_weight;
      const Eigen::ArrayXd added = addition(c.candidate.term, c.coefficients);
      c.rms = c.candidate.term.constant ? std::abs(added.mean()) : standard_deviation(added);
      found.push_back(std::move(c));
      order.push_back(i);
    }
    std::vector<double> alone;
    for (const std::size_t g : chosen_) alone.push_back(-model_->fit(groups_, {g}).rss);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return alone[a] > alone[b]; });
    list_visible(result);
    for (const std::size_t i : order) {
      if (term(i).named()) find_replacements(i, result, result.chosen.size());
      result.chosen.push_back(found[i]);
    }
  }

  const Evidence& record_;
  std::uint64_t seed_;
  ErrorSamples samples_;
  Scanned scanned_;
  std::vector<std::string> banned_;        ///< families that the veto_draws have refuted
  std::vector<std::string> found_before_;  ///< families of the previous pass's richest model
  std::vector<std::string> families_;      ///< of the previous pass
  Eigen::ArrayXd moved_;
  double extra_ = 0, correlation_ = 1, worth_ = 0, worth_of_shapes_ = 0, floor_ = 0;
  std::vector<Candidate> candidates_;
  std::vector<ColumnGroup> groups_;
  Eigen::MatrixXd columns_;
  Eigen::Index base_ = 0;
  Eigen::ArrayXd weight_, residual_;
  std::optional<LinearModel> model_;
  LinearModel::Set chosen_, richest_;
  LinearModel::Fit fit_;
};

}  // namespace

FoundCauses search_causes(const Evidence& record, std::uint64_t seed) {
  return CauseSearch(record, seed).found();
}

}  // namespace qerr
