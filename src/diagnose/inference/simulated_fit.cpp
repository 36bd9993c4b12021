#include "diagnose/inference/simulated_fit.hpp"

#include <cmath>

#include "core/solve.hpp"
#include "core/statistics.hpp"
#include "diagnose/record/with_effects.hpp"
#include "simulate/sensing.hpp"

namespace qerr {

namespace {

std::vector<Effect> named_effects(const Explanation& m, const std::vector<Eigen::VectorXd>& coefficients) {
  std::vector<Effect> effects;
  for (std::size_t i = 0; i < m.terms().size(); ++i) {
    if (!m.terms()[i].named()) continue;
    effects.push_back(m.terms()[i].effect);
    m.terms()[i].fill(effects.back(), coefficients[i]);
  }
  return effects;
}

std::vector<Eigen::VectorXd> coefficients_of(const Explanation& m) {
  std::vector<Eigen::VectorXd> all;
  for (std::size_t i = 0; i < m.terms().size(); ++i) all.push_back(m.coefficients(i));
  return all;
}

/// What the named effects add to the path in the simulation, at the rows of the sampling.
Eigen::ArrayXd simulated(const Sampling& s, const Explanation& m,
                         const std::vector<Eigen::VectorXd>& coefficients) {
  return s.averaged(with_effects(*s.record, named_effects(m, coefficients)).path - s.record->path);
}

/// Readings, without the mean of their rounding, less the path and less what terms without a name add.
Eigen::ArrayXd unexplained_by_others(const Sampling& s, const Explanation& m) {
  Eigen::ArrayXd left = s.evidence.measured - mean_error(s.evidence.encoder) - s.evidence.path;
  for (std::size_t i = 0; i < m.terms().size(); ++i)
    if (!m.terms()[i].named()) left -= addition(m.terms()[i], m.coefficients(i));
  return left;
}

double rms_of(const Evidence& e, const Eigen::ArrayXd& residual) {
  return std::sqrt((residual - (e.encoder.zero_known ? 0 : residual.mean())).square().mean());
}

/// Derivatives of the simulation by the coefficients of every named term.
std::vector<Eigen::ArrayXXd> derivatives(const Sampling& s, const Explanation& m,
                                         const std::vector<Eigen::VectorXd>& at) {
  constexpr double part = 1e-3;  // of a coefficient; of a term that is nearly zero, a tenth of a count
  std::vector<Eigen::ArrayXXd> all(at.size());
  for (std::size_t i = 0; i < at.size(); ++i) {
    const Term& t = m.terms()[i];
    if (!t.named()) continue;
    all[i].resize(s.evidence.rows(), t.size());
    for (Eigen::Index k = 0; k < t.size(); ++k) {
      const double reach = t.columns.col(k).abs().maxCoeff();
      const double least = reach > 0 ? 0.1 * s.evidence.step() / reach : 1e-12;
      const double step = std::max(part * at[i].norm(), least);
      auto more = at, less = at;
      more[i][k] += step;
      less[i][k] -= step;
      all[i].col(k) = (simulated(s, m, more) - simulated(s, m, less)) / (2 * step);
    }
  }
  return all;
}

/// One step of Gauss and Newton of all named coefficients.
std::vector<Eigen::VectorXd> improved(const Evidence& e, const std::vector<Eigen::ArrayXXd>& columns,
                                      const Eigen::ArrayXd& residual, std::vector<Eigen::VectorXd> at) {
  Eigen::Index count = e.encoder.zero_known ? 0 : 1;
  for (const Eigen::ArrayXXd& c : columns) count += c.cols();
  Eigen::MatrixXd all = Eigen::MatrixXd::Ones(e.rows(), count);
  Eigen::Index first = e.encoder.zero_known ? 0 : 1;
  for (const Eigen::ArrayXXd& c : columns) {
    if (c.cols() == 0) continue;
    all.middleCols(first, c.cols()) = c.matrix();
    first += c.cols();
  }
  const Eigen::VectorXd step = least_norm_solution(all, residual.matrix());
  first = e.encoder.zero_known ? 0 : 1;
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (columns[i].cols() == 0) continue;
    at[i] += step.segment(first, columns[i].cols());
    first += columns[i].cols();
  }
  return at;
}

}  // namespace

std::vector<Effect> named_effects(const Explanation& m) { return named_effects(m, coefficients_of(m)); }

SimulatedReadings simulated_readings(const Sampling& s, const Explanation& m) {
  const Evidence& e = s.evidence;
  const Eigen::ArrayXd added = simulated(s, m, coefficients_of(m));
  const Eigen::ArrayXd measured = e.measured - e.path;
  Eigen::ArrayXd reading = added;
  double variance = e.path_noise * e.path_noise;
  if (e.random_sigma.size() > 0) variance += e.random_sigma.square().mean();
  if (e.counted && e.encoder.zero_known)
    for (Eigen::Index k = 0; k < e.rows(); ++k)
      reading[k] = quantize(e.encoder, e.path[k] + added[k]) - e.path[k];
  else
    variance += e.step() * e.step() / 12;
  const auto square = [&](const Eigen::ArrayXd& x) {
    return (x - (e.encoder.zero_known ? 0 : x.mean())).square().mean();
  };
  return {square(measured), square(reading) + variance, square(measured - mean_error(e.encoder) - added)};
}

double left_by_simulation(const Sampling& s, const Explanation& m) {
  return rms_of(s.evidence, unexplained_by_others(s, m) - simulated(s, m, coefficients_of(m)));
}

bool is_reproduced(const Sampling& s, const Explanation& m) {
  constexpr double tenth = 1.1, rounding = 0.02;  // counts
  const Evidence& e = s.evidence;
  double floor = e.step() * e.step() / 12 + e.path_noise * e.path_noise;
  if (e.random_sigma.size() > 0) floor += e.random_sigma.square().mean();
  const Eigen::ArrayXd others = unexplained_by_others(s, m);
  Eigen::ArrayXd of_terms = others;
  for (std::size_t i = 0; i < m.terms().size(); ++i)
    if (m.terms()[i].named()) of_terms -= addition(m.terms()[i], m.coefficients(i));
  const double left = rms_of(e, of_terms), allowed = rounding * e.step();
  return left_by_simulation(s, m) <= tenth * left + allowed && left <= tenth * std::sqrt(floor) + allowed;
}

Explanation simulated_fit(const Sampling& s, const Explanation& model) {
  const Evidence& e = s.evidence;
  const Eigen::ArrayXd wanted = unexplained_by_others(s, model);
  std::vector<Eigen::VectorXd> at = coefficients_of(model);
  Eigen::ArrayXd added = simulated(s, model, at);
  double rms = rms_of(e, wanted - added);
  constexpr int most_steps = 8;
  for (int i = 0; i < most_steps; ++i) {
    const auto columns = derivatives(s, model, at);
    const auto target = improved(e, columns, wanted - added, at);
    double before = rms;
    for (double part = 1; part > 0.05; part /= 2) {  // shorter where the whole step is too long
      auto next = at;
      for (std::size_t k = 0; k < at.size(); ++k) next[k] += part * (target[k] - at[k]);
      const Eigen::ArrayXd there = simulated(s, model, next);
      const double now = rms_of(e, wanted - there);
      if (!(now < rms)) continue;
      at = std::move(next);
      added = there;
      rms = now;
      break;
    }
    constexpr double enough = 1e-4;
    if (!(rms < (1 - enough) * before)) break;
  }
  const auto columns = derivatives(s, model, at);
  Eigen::ArrayXd constant = added;
  for (std::size_t i = 0; i < at.size(); ++i)
    if (columns[i].cols() > 0) constant -= (columns[i].matrix() * at[i]).array();
  std::vector<Term> terms;
  for (std::size_t i = 0; i < at.size(); ++i) {
    const Term& t = model.terms()[i];
    if (!t.named()) {
      terms.push_back(t);
      continue;
    }
    Term simulated = with_columns(t, columns[i]);
    simulated.fixed = constant;
    simulated.reshaped = t.reshaped;  // its interval is as wide as if it were fitted, too
    constant = {};
    terms.push_back(std::move(simulated));
  }
  return Explanation(e, std::move(terms));
}

std::optional<std::size_t> needless_term(const Explanation& model) {
  constexpr double significant = 1e-4;
  std::optional<std::size_t> least;
  double largest = significant;
  for (std::size_t i = 0; i < model.terms().size(); ++i) {
    const Term& t = model.terms()[i];
    if (model.terms().size() < 2) continue;
    Explanation without = model;
    const Eigen::ArrayXd fixed = t.fixed;
    without.remove(i);
    if (fixed.size() > 0) {  // of all terms together
      Term other = without.terms()[0];
      other.fixed = other.fixed.size() > 0 ? (other.fixed + fixed).eval() : fixed;
      without.remove(0);
      without.add(std::move(other));
    }
    without.fit();
    const double ratio = 2 * (model.log_likelihood() - without.log_likelihood()) /
                         std::max(1.0, model.variance_inflation(t.columns));
    const double p = chi_squared_tail(std::max(0.0, ratio), static_cast<double>(t.size()));
    if (p > largest) largest = p, least = i;
  }
  return least;
}

}  // namespace qerr
