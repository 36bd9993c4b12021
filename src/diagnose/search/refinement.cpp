#include "diagnose/search/refinement.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "effect/effects/effects.hpp"

namespace qerr {

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
    refine_reshaped();
    for (std::size_t i = 0; i < choice_.chosen.size(); ++i) keep_size(i);
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
  void refine_reshaped() {
    std::vector<std::size_t> shaped;
    for (std::size_t i = 0; i < choice_.chosen.size(); ++i)
      if (term(i).reshaped) shaped.push_back(i);
    if (shaped.empty()) return;
    Eigen::MatrixXd columns = m_.columns(choice_.chosen);
    const Eigen::Index count = columns.cols();
    columns.conservativeResize(Eigen::NoChange, count + static_cast<Eigen::Index>(shaped.size()));
    for (std::size_t s = 0; s < shaped.size(); ++s) {
      const Term& t = term(shaped[s]);
      const double by = 1e-3 * t.half_width;
      const Eigen::ArrayXXd change = t.reshaped(m_.sampled(), t, t.shape + by).columns -
                                     t.reshaped(m_.sampled(), t, t.shape - by).columns;
      columns.col(count + static_cast<Eigen::Index>(s)) =
          change.matrix() * coefficients(shaped[s]) / (2 * by);
    }
    const LinearModel linear(columns, m_.samples().error.matrix(), m_.weight().matrix(), columns.cols());
    const LinearModel::Fit f = linear.fit({}, {});
    for (std::size_t s = 0; s < shaped.size(); ++s) {
      const Term& t = term(shaped[s]);
      const double by = std::clamp(f.coefficients[count + static_cast<Eigen::Index>(s)], -0.5 * t.half_width,
                                   0.5 * t.half_width);
      changed_ |= std::abs(by) > 0.02 * t.half_width;
      keep_shape(t, t.shape + (std::isfinite(by) ? by : 0.0));
    }
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
    if (!term(i).hysteresis) return;
    const double size = coefficients(i)[0];
    changed_ |= scanned_.hystereses.empty() || std::abs(size - scanned_.hystereses.front()) > 0.02 * size;
    next.hystereses.push_back(size);
  }

  /// Keeps what a term of a scan needs to be found again.
  void keep(const Candidate& c) {
    const Term& t = c.term;
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
