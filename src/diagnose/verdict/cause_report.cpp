#include "diagnose/verdict/cause_report.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/statistics.hpp"
#include "diagnose/inference/found_parameters.hpp"
#include "diagnose/search/unnamed_terms.hpp"
#include "qerr/core/quantity.hpp"
#include "qerr/effect/effect.hpp"
#include "qerr/effect/effect_kind.hpp"

namespace qerr {

namespace {

std::optional<double> order_of(const Effect& e) {
  return e.numbers.count("order") ? std::optional(e.number("order")) : std::nullopt;
}

std::optional<double> frequency_of(const Effect& e) {
  return e.numbers.count("frequency") ? std::optional(e.number("frequency")) : std::nullopt;
}

/// Effects that no record of these signals can distinguish from the one found.
std::vector<std::string> inseparable_twins(const Effect& effect, const Evidence& e) {
  std::vector<std::string> names;
  for (const Twin& twin : effect_kind(effect.type).twins)
    if (twin.inseparable && twin.inseparable(effect, e)) names.emplace_back(twin.other);
  return names;
}

/// Adds one encoder's causes, alternatives and unexplained rest to a diagnosis. Borrows its arguments for one
/// call of `add`.
class CauseReport {
 public:
  CauseReport(Diagnosis& d, const Evidence& e, const Gain& gain) : d_(d), e_(e), gain_(gain) {}

  void add_terms(const Selection& s, const Scatter& scatter) {
    const auto parameters = found_parameters(e_, s.model);
    for (std::size_t i = 0; i < s.model.terms().size(); ++i) {
      const Term& t = s.model.terms()[i];
      Effect effect = t.effect;
      t.fill(effect, s.model.coefficients(i));
      if (!t.named()) {
        add_unnamed(t, effect, std::sqrt(2.0) * size_of(s.model, i));
        d_.unexplained.back().curve = residual_curve(e_, s.model, i);
        continue;
      }
      if (t.constant && displaced_edges(scatter)) continue;  // see add_zero
      std::vector<std::string> others = inseparable_twins(effect, e_);
      Cause cause{effect, parameters[i], s.p_values[i], gain_, 0};
      for (const Alternative& other : s.alternatives) {
        if (other.term != i) continue;
        others.push_back(other.effect.type);
        if (other.effect.type == effect.type) include_order(cause, other.effect);
      }
      cause.rms = rms(addition(t, s.model.coefficients(i)));
      cause.rms_without = std::sqrt(gain_.rms_after * gain_.rms_after + s.lost[i]);
      cause.curve = residual_curve(e_, s.model, i);
      add(std::move(cause), others);
    }
  }

  void add_scatter(const Scatter& scatter) {
    for (const ScatterCause& c : scatter.causes) {
      Cause cause{c.effect, {}, c.p_value, gain_, c.rms};
      for (const auto& [name, value] : c.effect.numbers) {
        const double half = c.relative_error * std::abs(value);
        cause.parameters.push_back({name, value, value - half, value + half});
      }
      cause.rms_without = std::hypot(gain_.rms_after, c.rms);
      std::vector<std::string> others;
      if (c.alternative) others.push_back(c.alternative->type);
      add(std::move(cause), others);
    }
  }

  /// Displaced edges have a mean of their own: the zero's error is the mean beyond it. Which channel's edges
  /// are the displaced ones is a convention, and so is a zero's error up to the displacement.
  void add_zero(const Selection& s, const Scatter& scatter) {
    const Effect* edges = displaced_edges(scatter);
    if (!edges || !e_.encoder.zero_known) return;
    const double of_edges = effect_kind(edges->type).share(*edges, e_.encoder, {})->mean,
                 error = 0.5 * scatter.pattern.alternating_error * e_.step();
    double mean = 0, p_value = 0;
    for (std::size_t i = 0; i < s.model.terms().size(); ++i)
      if (s.model.terms()[i].constant) mean = s.model.coefficients(i)[0], p_value = s.p_values[i];
    const double zero = mean - of_edges;
    const double by_convention = std::abs(scatter.pattern.alternating) * e_.step();
    if (std::abs(zero) < by_convention + std::max(material * e_.step(), 3 * error)) return;
    for (const Term& t : named_terms(e_)) {
      if (!t.constant) continue;
      Cause cause{t.effect, {}, p_value, gain_, std::abs(zero)};
      t.fill(cause.effect, Eigen::VectorXd::Constant(1, zero));
      for (const auto& [name, value] : cause.effect.numbers)
        cause.parameters.push_back({name, value, value - 2 * error, value + 2 * error});
      cause.rms_without = std::hypot(gain_.rms_after, zero);
      add(std::move(cause), {});
    }
  }

  void add_visible(const std::vector<VisibleEffect>& all) {
    for (const VisibleEffect& v : all) {
      Visible out;
      out.effect = v.effect, out.joint = e_.joint;
      out.parameter = v.parameter, out.hidden_by = v.hidden_by;
      if (v.smallest > 0) out.smallest = v.smallest;
      for (const Parameter& p : effect_kind(v.effect).parameters)
        if (p.name == v.parameter) out.unit = unit_name(dimension_at(p, e_.prismatic));
      d_.visible.push_back(std::move(out));
    }
  }

  void add_remainder(const Remainder& r) {
    if (!r.what.empty()) d_.unexplained.push_back({e_.joint, r.what, {}, {}, r.size, r.shape});
  }

 private:
  /// The cause that displaces edges; null: none does.
  static const Effect* displaced_edges(const Scatter& scatter) {
    for (const ScatterCause& c : scatter.causes)
      if (!effect_kind(c.effect.type).random()) return &c.effect;
    return nullptr;
  }

  /// Orders that fit as well are within the interval of the order.
  static void include_order(Cause& cause, const Effect& other) {
    const bool same_shaft = other.choices == cause.effect.choices;
    for (FoundParameter& p : cause.parameters)
      if (p.name == "order" && same_shaft) {
        p.lower = std::min(p.lower, other.number("order"));
        p.upper = std::max(p.upper, other.number("order"));
      }
  }

  void add_unnamed(const Term& t, const Effect& filled, double amplitude) {
    Unidentified u{e_.joint, t.unnamed, order_of(filled), frequency_of(filled), amplitude, t.pattern};
    u.figures = filled.numbers;
    u.next = t.next.empty() && filled.numbers.count("rate") > 0 ? next_of_rate : t.next;
    d_.unexplained.push_back(std::move(u));
  }

  void add(Cause cause, const std::vector<std::string>& others) {
    std::set<std::string> reported{cause.effect.type};
    for (const std::string& other : others)
      if (reported.insert(other).second)
        d_.alternatives.push_back(
            {cause.effect.type, other, e_.joint, std::string(record_advice(cause.effect.type, other))});
    d_.causes.push_back(std::move(cause));
  }

  Diagnosis& d_;
  const Evidence& e_;
  const Gain& gain_;
};

}  // namespace

void add(Diagnosis& d, const Finding& f, const Gain& gain) {
  CauseReport report(d, f.evidence(), gain);
  report.add_terms(*f.selection, f.scatter);
  report.add_scatter(f.scatter);
  report.add_zero(*f.selection, f.scatter);
  report.add_remainder(f.remainder);
  report.add_visible(f.visible);
}

namespace {

constexpr Eigen::Index bins = 40;

struct Argument {
  std::string name, unit;
  Eigen::ArrayXd values;
};

/// Means of a column in bins of a quantity; NaN: no rows.
Eigen::ArrayXd binned(const Eigen::ArrayXd& column, const Eigen::ArrayXd& by, double low, double width) {
  Eigen::ArrayXd sums = Eigen::ArrayXd::Zero(bins), counts = sums;
  for (Eigen::Index k = 0; k < column.size(); ++k) {
    const auto bin = std::min(bins - 1, static_cast<Eigen::Index>((by[k] - low) / width));
    sums[bin] += column[k], counts[bin] += 1;
  }
  return sums / counts;
}

/// Mean square of a column about its means in the bins.
double scatter_within(const Eigen::ArrayXd& column, const Eigen::ArrayXd& by) {
  const double low = by.minCoeff(), width = (by.maxCoeff() - low) / bins;
  if (!(width > 0)) return column.square().mean();
  const Eigen::ArrayXd means = binned(column, by, low, width);
  double sum = 0;
  for (Eigen::Index k = 0; k < column.size(); ++k)
    sum +=
        std::pow(column[k] - means[std::min(bins - 1, static_cast<Eigen::Index>((by[k] - low) / width))], 2);
  return sum / static_cast<double>(column.size());
}

std::vector<Argument> quantities(const Evidence& e, const Term& t) {
  const std::string coordinate = e.prismatic ? "m" : "rad";
  std::vector<Argument> all{{"angle", coordinate, e.path}};
  if (e.prismatic) all[0].name = "position";
  if (e.ordered) {
    all.push_back({"speed", coordinate + "/s", e.velocity});
    all.push_back({"time", "s", e.time});
  }
  if (e.effort.size() > 0) all.push_back({"effort", e.prismatic ? "N" : "N m", e.effort});
  if (e.temperature.size() > 0) all.push_back({"temperature", "K", e.temperature});
  if (const double order = std::abs(wave_number(t.effect, e.encoder)); t.harmonic && order > 0) {
    const double period = 2 * std::numbers::pi / order;
    all.push_back({all[0].name, coordinate,
                   e.path.unaryExpr([&](double x) { return x - period * std::floor(x / period); })});
  }
  return all;
}

}  // namespace

ResidualCurve residual_curve(const Evidence& e, const Explanation& m, std::size_t term) {
  const Term& t = m.terms()[term];
  const Eigen::ArrayXd added = addition(t, m.coefficients(term));
  ResidualCurve curve;
  if (t.constant || standard_deviation(added) == 0 || e.rows() < 2 * bins) return curve;
  const Eigen::ArrayXd residual = e.measured - e.path - m.addition() + added;
  std::vector<Argument> all = quantities(e, t);
  std::size_t best = 0;
  double least = scatter_within(added, all[0].values);
  for (std::size_t i = 1; i < all.size(); ++i)
    if (const double here = scatter_within(added, all[i].values); here < least) least = here, best = i;
  const Argument& q = all[best];
  const double low = q.values.minCoeff(), width = (q.values.maxCoeff() - low) / bins;
  const Eigen::ArrayXd observed = binned(residual, q.values, low, width),
                       fit = binned(added, q.values, low, width);
  curve.against = q.name, curve.unit = q.unit;
  for (Eigen::Index i = 0; i < bins; ++i) {
    curve.at.push_back(low + (static_cast<double>(i) + 0.5) * width);
    curve.residual.push_back(observed[i]);
    curve.fit.push_back(fit[i]);
  }
  return curve;
}

}  // namespace qerr
