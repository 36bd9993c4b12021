#include "diagnose/search/dictionary.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "core/solve.hpp"
#include "core/statistics.hpp"
#include "core/text.hpp"
#include "diagnose/record/with_effects.hpp"
#include "diagnose/search/unnamed_terms.hpp"
#include "qerr/effect/effect_kind.hpp"

namespace qerr {

namespace {

constexpr int time_constants = 15;

bool same_term(const Term& a, const Term& b) {
  // Numbers of a linear term are what the rows say, each sampling in its own way.
  const bool linear = !a.harmonic && !a.step && !a.reshaped && !a.hysteresis && a.fill == b.fill;
  return a.effect.type == b.effect.type && a.effect.choices == b.effect.choices &&
         (a.effect.numbers == b.effect.numbers || (linear && a.size() == b.size()));
}

/// A term that these rows do not offer: of other rows than its own it has nothing, but where another shape
/// computes it anew, or parameters do.
Term not_offered(const Term& t, const Sampling& s) {
  const Eigen::Index rows = s.evidence.rows();
  if (t.relinearized && t.columns.rows() != rows)
    return t.relinearized(s.evidence, t, Eigen::VectorXd::Zero(t.size()));
  return t.reshaped || t.columns.rows() == rows ? t : with_columns(t, Eigen::ArrayXXd::Zero(rows, t.size()));
}

/// Geometric series from `low` to `high`.
std::vector<double> series(double low, double high, int count) {
  std::vector<double> all;
  for (int i = 0; i < count; ++i) all.push_back(low * std::pow(high / low, i / std::max(1.0, count - 1.0)));
  return all;
}

std::vector<double> joined(std::vector<double> a, const std::vector<double>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// The terms of one kind of effect: see EffectKind.
using TermsOf = std::vector<Term> (*)(const RecordSignals&);

using Histories = std::map<std::pair<std::string, double>, std::shared_ptr<const Term>>;
using Shapes = std::map<std::string, std::vector<double>>;

class Candidates {
 public:
  Candidates(const Sampling& s, const Scanned& scanned, const std::vector<Addition>& displacing,
             Histories& histories, std::map<double, bool>& driven, Shapes& shapes)
      : s_(s),
        e_(s.evidence),
        scanned_(scanned),
        displacing_(displacing),
        histories_(histories),
        driven_(driven),
        shapes_(shapes),
        clocks_(clocks_of(e_, scanned)) {
    for (const Effect& clock : clocks_)
      for (const auto& [name, value] : clock.numbers) read_late_ += ' ' + significant(value, 6);
  }

  std::vector<Candidate> all() && {
    add_named();
    add_orders();
    add_arcs();
    add_loaded_orders();
    if (e_.ordered) {
      add_in_time();
      add_hystereses();
    }
    add_couplings();
    if (!e_.is_stationary()) add_in_position();
    return std::move(found_);
  }

 private:
  void add(Term t, std::string family, double alternatives, std::function<Term(const Sampling&)> over) {
    add(std::make_shared<const Term>(searchable(std::move(t))), std::move(family), alternatives,
        std::move(over));
  }

  void add(std::shared_ptr<const Term> t, std::string family, double alternatives,
           std::function<Term(const Sampling&)> over) {
    if (t->columns.rows() == 0 || !t->columns.isFinite().all()) return;
    found_.push_back(
        {std::move(t), std::move(family), alternatives, 0, 0, scanned_number_, false, std::move(over)});
  }

  /// A term along the path that what was found displaces.
  Term displaced(Term t) const {
    Eigen::ArrayXd moved;
    if (t.along)
      for (const Addition& a : displacing_)
        if (displaces(a.term, t)) moved = moved.size() > 0 ? (moved + a.added).eval() : a.added;
    return moved.size() > 0 ? t.along(e_, t, moved) : t;
  }

  /// A term without history: computed from the averaged signals.
  void add_plain(std::string family, double alternatives, std::function<Term(const RecordSignals&)> of) {
    Term t = of(e_);
    add(std::move(t), std::move(family), alternatives,
        [of = std::move(of)](const Sampling& s) { return of(s.evidence); });
  }

  /// One that no pass changes.
  void add_fixed(const std::string& family, double shape, double alternatives,
                 const std::function<Term(const RecordSignals&)>& of) {
    add_history(family, family, shape, alternatives, [of](const Sampling& s) { return of(s.evidence); });
  }

  void add_named() {
    for (const EffectKind& kind : effect_kinds())
      if (kind.terms) add_terms(kind.terms);
  }

  void add_terms(TermsOf terms) {
    std::size_t number = 0;
    for (Term& t : terms(e_)) {
      const std::size_t place = number++;
      const double order = t.effect.number_or("order", 0);
      if (t.harmonic && order > 1 && periods_covered(t.effect, e_) < least_periods) continue;
      // In a table of even steps an order of whole periods a step is a constant.
      const Eigen::ArrayXd first = t.columns.row(0).transpose();
      constexpr double varies = 0.01;  // of an amplitude: less than what is worth a name
      if (t.harmonic && !e_.is_stationary() &&
          (t.columns.rowwise() - first.transpose()).abs().maxCoeff() < varies)
        continue;
      const Term original = t;
      // Linearizations of one effect differ in their columns alone: they are told apart by their place.
      const auto over = [original, place, terms](const Sampling& s) {
        std::vector<Term> all = terms(s.evidence);
        if (place < all.size() && same_term(all[place], original)) return all[place];
        for (Term& fresh : all)
          if (same_term(fresh, original)) return fresh;
        return not_offered(original, s);
      };
      if (t.shapes) {
        add_at_shapes(t);
        continue;
      }
      if (t.reshaped) {
        add_reshaped(t, over);
        continue;
      }
      t = displaced(std::move(t));
      std::string family = t.effect.type;
      if (order > 0) family = family_of_order(t);
      if (t.hysteresis) add_sizes(t, family);
      if (t.relinearized) add_linearizations(t, terms, family);
      if (effect_kind(t.effect.type).stage == Stage::clock)
        t.relinearized ? add_shifts(t, family) : add_beside_clocks(t, family);
      add(std::move(t), family, 1, over);
    }
  }

  std::string family_of_order(const Term& t) const {
    return qerr::family_of_order(wave_number(t.effect, e_.encoder));
  }

  /// A hysteresis at sizes for which its column is computed from what drives it: the reference's path, or the
  /// readings where they are quiet; the operator would take their noise for play.
  void add_sizes(const Term& original, const std::string& family) {
    const Evidence& r = *s_.record;
    std::vector<double> sizes = scanned_.hystereses;
    const double low = std::max(r.step(), 12 * r.path_noise), high = 0.6 * r.range();
    if (high > low)
      sizes = joined(sizes, series(low, high, std::max(2, static_cast<int>(2 * std::log2(high / low)))));
    const double least = original.of_reference ? low : least_driven(sizes);
    const auto drive_of = [by_reference = original.of_reference, clocks = clocks_](const Evidence& e,
                                                                                   double size) {
      return by_reference ? PathAsRead(e, clocks).of_all_rows() : e.drive(size);
    };
    const auto at = [original](const Sampling& s, const Eigen::ArrayXd& drive, double size) {
      Term t = original;
      t.columns = s.averaged(original.hysteresis(drive, size));
      return t;
    };
    std::optional<Eigen::ArrayXd> drive;  // that of the reference is the same for all sizes
    for (const double size : sizes) {
      if (!(size >= least)) continue;
      const std::string driven = original.of_reference ? " of the load" + read_late_ : "";
      const auto here = [&](const Sampling& s) {
        if (!drive || !original.of_reference) drive = drive_of(r, size);
        return at(s, *drive, size);
      };
      found_.push_back({history(family + driven, size, here), family, static_cast<double>(sizes.size()),
                        size / 1.5, size * 1.5, 0, false, [at, drive_of, size](const Sampling& s) {
                          return at(s, drive_of(*s.record, size), size);
                        }});
    }
  }

  /// The least of some sizes that the readings drive; NaN: they drive none. They do so from one size on.
  double least_driven(std::vector<double> sizes) const {
    std::sort(sizes.begin(), sizes.end());
    const auto least = std::partition_point(sizes.begin(), sizes.end(), [&](double size) {
      const auto [place, fresh] = driven_.try_emplace(size);
      if (fresh) place->second = s_.record->readings_drive(size);
      return !place->second;
    });
    return least == sizes.end() ? std::nan("") : *least;
  }

  /// A non-linear term about the parameters that the previous pass has led to.
  void add_linearizations(const Term& original, TermsOf terms, const std::string& family) {
    for (const auto& [effect, p] : scanned_.linearizations) {
      if (effect != original.effect.type || p.size() != original.size()) continue;
      add(original.relinearized(e_, original, p), family, 1, [original, terms, p = p](const Sampling& s) {
        for (Term& fresh : terms(s.evidence))
          if (same_term(fresh, original) && fresh.size() == original.size())
            return fresh.relinearized(s.evidence, fresh, p);
        return not_offered(original, s);
      });
    }
  }

  /// A shift in time of several rows, per unit of it, as the whole record has it: at a reversal that is
  /// sharper than the shift is long its linearization by the rate is no shift.
  void add_shifts(const Term& original, const std::string& family) {
    const Evidence& r = *s_.record;
    constexpr double fewest_rows = 1.5, longest_part = 0.02, ratio = 1.5;
    std::vector<double> sizes;
    for (const auto& [effect, p] : scanned_.linearizations)
      if (effect == original.effect.type && p.size() == 1 && std::abs(p[0]) > fewest_rows * r.interval)
        sizes.push_back(p[0]);
    const double longest = longest_part * (r.time[r.rows() - 1] - r.time[0]);
    for (double size = fewest_rows * r.interval; size < longest; size *= ratio) sizes.push_back(size);
    for (const double size : sizes) {
      const auto over = [original, size](const Sampling& s) {
        Effect shift = original.effect;
        original.fill(shift, Eigen::VectorXd::Constant(1, size));
        PathAsRead shifted(*s.record, {shift});
        const Eigen::ArrayXd& path = s.record->joint_angle();
        return with_columns(original,
                            s.averaged_rows([&](Eigen::Index k) { return shifted(k) - path[k]; }) / size);
      };
      const auto [least, most] = std::minmax({size / ratio, size * ratio});
      found_.push_back({history(family + " as recorded", size, over), family,
                        static_cast<double>(sizes.size()), least, most, 0, false, over});
    }
  }

  /// What another clock adds to a reading that is late: its linearization is that of a reading in time.
  void add_beside_clocks(const Term& original, const std::string& family) {
    const auto is_own = [&](const Effect& clock) { return clock.type == original.effect.type; };
    std::vector<Effect> late = clocks_;
    if (std::erase_if(late, is_own) == 0 || late.empty()) return;
    for (const auto& [effect, p] : scanned_.linearizations) {
      if (effect != original.effect.type) continue;
      const auto over = [original, late, p = p](const Sampling& s) {
        std::vector<Effect> all = late;
        original.fill(all.emplace_back(original.effect), p);
        PathAsRead with(*s.record, all), without(*s.record, late);
        return with_columns(original,
                            s.averaged_rows([&](Eigen::Index k) { return with(k) - without(k); }) / p[0]);
      };
      add_history(family, family + " as recorded" + read_late_, p[0], 1, over);
    }
  }

  /// A term with a time constant: at a series of them, and at those that were refined.
  void add_reshaped(const Term& t, const std::function<Term(const Sampling&)>& original) {
    if (has_family(t.effect.type)) return;
    const double duration = e_.time[e_.rows() - 1];
    // Of an approach that the scan of events has found it is that, where it begins with the record: between
    // those of a series it would lose to the approach alone.
    std::vector<double> found = scanned_.time_constants;
    for (const Event& event : scanned_.events) found.push_back(event.time_constant);
    for (const double shape : joined(found, series(duration / 100, 2 * duration, time_constants))) {
      const auto at = [&](const Sampling&) { return t.reshaped(e_, t, shape); };
      add(history(t.effect.type, shape, at), t.effect.type, time_constants,
          [original, shape](const Sampling& s) {
            const Term fresh = original(s);
            return fresh.reshaped ? fresh.reshaped(s.evidence, fresh, shape) : fresh;
          });
    }
  }

  /// A term with a parameter that the whole record tells.
  void add_at_shapes(const Term& t) {
    const std::string name = t.of_reference ? t.effect.type + " of the load" : t.effect.type;
    const auto [place, fresh] = shapes_.try_emplace(name);
    if (fresh) place->second = t.shapes(*s_.record);
    const std::vector<double>& shapes = place->second;
    for (const double shape : shapes)
      add_history(t.effect.type, name, shape, static_cast<double>(shapes.size()),
                  [t, shape](const Sampling& s) {
                    Term at = t.reshaped(*s.record, t, shape);
                    Eigen::ArrayXXd columns(s.evidence.rows(), at.size());
                    for (Eigen::Index i = 0; i < at.size(); ++i)
                      columns.col(i) = s.averaged(at.columns.col(i));
                    return with_columns(std::move(at), std::move(columns));
                  });
  }

  bool has_family(const std::string& family) const {
    return std::any_of(found_.begin(), found_.end(), [&](const Candidate& c) { return c.family == family; });
  }

  void add_orders() {
    for (const Scanned::Rate& r : scanned_.orders) {
      for (Term& t : whole_orders_near(e_, r.value)) {
        const std::string family = family_of_order(t);
        if (has_family(family) || periods_covered(t.effect, e_) < least_periods) continue;
        const double order = t.effect.number("order");
        const bool of_encoder = t.effect.choices.at("shaft") == "encoder";
        t = displaced(std::move(t));
        add(std::move(t), family, 2 * order,
            [order, of_encoder](const Sampling& s) { return periodic_term(s.evidence, order, of_encoder); });
      }
      if (r.whole) continue;
      Term free = free_order_term(e_, r.value);
      free.pattern = Shape::order;
      free = displaced(std::move(free));
      add(std::move(free), "free order " + significant(r.value, 6), r.hypotheses,
          [value = r.value](const Sampling& s) {
            Term t = free_order_term(s.evidence, value);
            t.pattern = Shape::order;
            return t;
          });
    }
  }

  /// Low orders of which the record covers less than what a search chooses.
  void add_arcs() {
    if (e_.is_stationary()) return;
    for (const bool of_encoder : {true, false}) {
      const double ratio = std::abs(e_.encoder.shaft_ratio);
      if (!of_encoder && (e_.prismatic || std::abs(ratio - 1) < 1e-9)) continue;
      const double turns = (of_encoder ? ratio : 1) * e_.range() / (2 * std::numbers::pi);
      for (const double order : {1.0, 2.0, 3.0, 4.0, 6.0, 8.0}) {
        if (order * turns >= least_periods) break;
        Term t = periodic_term(e_, order, of_encoder);
        const std::string family = family_of_order(t);
        if (has_family(family)) continue;
        const std::size_t before = found_.size();
        add(std::move(t), family, 1,
            [order, of_encoder](const Sampling& s) { return periodic_term(s.evidence, order, of_encoder); });
        if (found_.size() > before) found_.back().replaces_only = true;
      }
    }
  }

  void add_loaded_orders() {
    for (const Scanned::Rate& r : scanned_.loaded_orders)
      add_plain("loaded order " + significant(r.value, 6), r.hypotheses,
                [value = r.value](const RecordSignals& s) { return loaded_order_term(s, value); });
  }

  void add_in_time() {
    if (e_.temperature.size() > 0)
      add_plain("growth", 2, [](const RecordSignals& s) { return thermal_growth_term(s); });
    const double duration = e_.time[e_.rows() - 1];
    if (!(duration > 0)) return;
    if (!e_.is_stationary())
      for (const double constant : joined(scanned_.time_constants, series(duration / 30, 2 * duration, 8)))
        add_fixed("growth", constant, 8,
                  [constant](const RecordSignals& s) { return growth_term(s, constant); });
    // On one sweep at constant speed a function of time is one of the position, and so is named; a loss of
    // counts is none of those that repeat with it.
    const bool one_sweep = is_one_sweep();
    for (const Scanned::Rate& r : scanned_.lines)
      if (!one_sweep)
        add_plain("line " + significant(r.value, 6), r.hypotheses,
                  [f = r.value](const RecordSignals& s) { return vibration_term(s, f); });
    int number = 0;
    for (const Event& event : scanned_.events) {
      scanned_number_ = static_cast<std::size_t>(number);
      const std::string family = "event " + std::to_string(number++);
      add_plain(family, event.hypotheses,
                [t = event.time](const RecordSignals& s) { return step_term(s, t); });
      if (one_sweep) continue;
      add_plain(family, 2 * event.hypotheses,
                [t = event.time](const RecordSignals& s) { return offset_step_term(s, t); });
      add_plain(family, 4 * event.hypotheses, [event](const RecordSignals& s) {
        return ramp_term(s, event.ramp_start, event.ramp_duration);
      });
      add_plain(family, 4 * event.hypotheses, [event](const RecordSignals& s) {
        return transition_term(s, event.approach_start, event.time_constant);
      });
    }
    if (one_sweep) return;
    add_fixed("time", 1, 1, [](const RecordSignals& s) { return steady_change_term(s); });
    for (const int degree : {2, 3, 4, 5})
      add_fixed("time", degree, 8,
                [degree](const RecordSignals& s) { return time_polynomial_term(s, degree); });
    for (const Eigen::Index knots : {10, 20, 40})
      if (e_.rows() > 8 * knots)
        add_fixed("time", static_cast<double>(knots), 8,
                  [knots](const RecordSignals& s) { return time_table_term(s, knots); });
  }

  void add_couplings() {
    const auto& others = s_.record->others;
    if (others.empty() || !others_explain_all()) return;
    for (std::size_t i = 0; i < others.size(); ++i)
      add_history("coupling of " + others[i]->joint, "coupling", static_cast<double>(i),
                  static_cast<double>(others.size()), [i](const Sampling& s) {
                    const Evidence& other = *s.record->others[i];
                    return coupling_term(s.evidence, other.joint, s.averaged(other.path));
                  });
  }

  /// Whether the angles of all joints leave next to nothing of the error, as a coupling's do. Joints that
  /// move together, and loads that vary with the pose, have some of any error.
  bool others_explain_all() const {
    const auto& others = s_.record->others;
    Eigen::MatrixXd columns(e_.rows(), static_cast<Eigen::Index>(others.size()) + 2);
    columns.leftCols(2) << Eigen::VectorXd::Ones(e_.rows()), e_.path.matrix();
    for (std::size_t i = 0; i < others.size(); ++i)
      columns.col(static_cast<Eigen::Index>(i) + 2) = s_.averaged(others[i]->path).matrix();
    columns.rightCols(columns.cols() - 1).rowwise() -=
        columns.rightCols(columns.cols() - 1).colwise().mean().eval();
    const Eigen::VectorXd error = (e_.measured - e_.path).matrix();
    const Eigen::MatrixXd normal = columns.transpose() * columns;
    const Eigen::ArrayXd left =
        (error - columns * solve_symmetric(normal, columns.transpose() * error)).array();
    return rms(left) < std::max(0.1 * standard_deviation(error.array()), 0.4 * e_.step() + e_.noise);
  }

  bool is_one_sweep() const {
    return fit_line(e_.time, e_.path).residual_rms < 0.01 * standard_deviation(e_.path) &&
           !e_.is_stationary();
  }

  const std::shared_ptr<const Term>& history(const std::string& name, double shape,
                                             const std::function<Term(const Sampling&)>& of) {
    const auto [place, fresh] = histories_.try_emplace({name, shape});
    if (fresh) place->second = std::make_shared<const Term>(searchable(of(s_)));
    return place->second;
  }

  void add_history(const std::string& family, const std::string& name, double shape, double alternatives,
                   const std::function<Term(const Sampling&)>& of) {
    add(history(name, shape, of), family, alternatives, of);
  }

  void add_hystereses() {
    if (e_.is_stationary()) return;
    const Evidence& r = *s_.record;
    constexpr int travels = 10, constants = 10;
    constexpr double few_samples = 4;
    for (const double travel : joined(scanned_.travels, series(r.step(), 0.3 * r.range(), travels))) {
      // A state that is forgotten within few samples is not told.
      const auto over = [travel, clocks = clocks_](const Sampling& s) {
        return friction_term(s, PathAsRead(*s.record, clocks).of_all_rows(), travel);
      };
      const Term& both = *history("friction" + read_late_, travel, over);
      const Eigen::Index told = both.columns.col(1).square().sum() > few_samples ? 2 : 1;
      const auto told_of = [told](Term t) {
        t.columns.conservativeResize(Eigen::NoChange, told);
        return t;
      };
      add(told_of(both), "hysteresis", travels,
          [over, told_of](const Sampling& s) { return told_of(over(s)); });
    }
    const double duration = e_.time[e_.rows() - 1];
    for (const double constant : series(duration / 300, duration / 10, constants))
      add_history("relaxation", "relaxation", constant, 2 * constants,
                  [constant](const Sampling& s) { return relaxation_term(s, constant); });
    for (const double constant : series(duration / 300, duration / 10, constants))
      add_history("relaxation", "settling", constant, 2 * constants,
                  [constant](const Sampling& s) { return settling_term(s, constant); });
    add_fixed("speed", 0, 1, [](const RecordSignals& s) { return speed_term(s); });
    if (e_.counted && e_.path_noise < e_.step())
      add_history("states", "states", 0, 1, [](const Sampling& s) { return state_pattern_term(s); });
  }

  void add_in_position() {
    int number = 0;
    for (const Bump& p : scanned_.places) {
      scanned_number_ = static_cast<std::size_t>(number);
      const std::string family = "bump " + std::to_string(number++);
      add_plain(family, p.hypotheses,
                [p](const RecordSignals& s) { return bump_term(s, p.position, p.width); });
    }
    for (const int degree : {2, 3, 4, 5})
      add_fixed("position", degree, 8,
                [degree](const RecordSignals& s) { return position_polynomial_term(s, degree); });
    for (const Eigen::Index knots : {10, 26})
      if (e_.rows() > 8 * knots)
        add_fixed("position", static_cast<double>(knots), 8,
                  [knots](const RecordSignals& s) { return position_table_term(s, knots); });
  }

  const Sampling& s_;
  const Evidence& e_;
  const Scanned& scanned_;
  const std::vector<Addition>& displacing_;
  Histories& histories_;
  std::map<double, bool>& driven_;
  Shapes& shapes_;
  std::vector<Effect> clocks_;  ///< that the previous pass has found
  std::string read_late_;       ///< their sizes
  std::size_t scanned_number_ = 0;
  std::vector<Candidate> found_;
};

}  // namespace

std::vector<Effect> clocks_of(const RecordSignals& s, const Scanned& scanned) {
  std::vector<Effect> clocks;
  for (const Scanned::Linearization& found : scanned.linearizations) {
    const EffectKind& kind = effect_kind(found.effect);
    if (kind.stage != Stage::clock) continue;
    for (const Term& t : kind.terms(s))
      if (found.effect == t.effect.type && found.parameters.size() == t.size())
        t.fill(clocks.emplace_back(t.effect), found.parameters);
  }
  return clocks;
}

std::string family_of_order(double wave_number) { return "order " + significant(std::abs(wave_number), 6); }

Term searchable(Term t) {
  if (t.fixed.size() == 0) return t;
  t.columns.conservativeResize(Eigen::NoChange, t.columns.cols() + 1);
  t.columns.rightCols(1) = t.fixed;
  t.fixed.resize(0);
  return t;
}

std::vector<Candidate> Dictionary::candidates(const Scanned& scanned,
                                              const std::vector<Addition>& displacing) {
  return Candidates(*sampling_, scanned, displacing, histories_, driven_, shapes_).all();
}

std::vector<Term> whole_orders_near(const RecordSignals& s, double order) {
  std::vector<Term> whole;
  const double resolution = 0.5 * std::numbers::pi / std::max(1e-12, s.range());
  const double ratio = std::abs(s.encoder.shaft_ratio);
  for (const bool of_encoder : {true, false}) {
    if (!of_encoder && (s.prismatic || std::abs(ratio - 1) < 1e-9)) continue;
    const double shaft = of_encoder ? ratio : 1, nearest = std::round(order / shaft);
    // A whole number within 0.03: an error rate of 6 % for an order that is a fraction. A short path does not
    // tell an order that well.
    const double off = std::abs(order - nearest * shaft);
    if (nearest < 1 || off > std::min(resolution, std::max(0.03 * shaft, resolution / 4))) continue;
    whole.push_back(periodic_term(s, nearest, of_encoder));
  }
  return whole;
}

}  // namespace qerr
