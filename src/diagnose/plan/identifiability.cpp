#include "diagnose/plan/identifiability.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/solve.hpp"
#include "core/statistics.hpp"
#include "qerr/effect/effect_kind.hpp"

namespace qerr {

namespace {

constexpr double tails = 8;  ///< of the normal density that are integrated [sigma]

double density(double z) { return std::exp(-0.5 * z * z) / std::sqrt(2 * std::numbers::pi); }

}  // namespace

ReadingInformation reading_information(double noise) {
  // Midpoint rule over one count, with 40 points per standard deviation of the noise.
  const int points = static_cast<int>(std::clamp(40 / noise, 200.0, 40000.0));
  const double most = std::ceil(tails * noise);
  ReadingInformation sum;
  for (int i = 0; i < points; ++i) {
    const double x = (i + 0.5) / points;
    for (double k = -most; k <= most; ++k) {
      const double a = (k - x) / noise, b = (k + 1 - x) / noise, p = normal_probability(a, b);
      if (p < 1e-14) continue;
      const double by_position = density(a) - density(b), by_sigma = a * density(a) - b * density(b);
      sum.position += by_position * by_position / p;
      sum.log_sigma += by_sigma * by_sigma / p;
    }
  }
  return {sum.position / (points * noise * noise), sum.log_sigma / points};
}

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

double smallest_eigenvalue(const Eigen::MatrixXd& m) {
  return m.size() == 1 ? m(0, 0) : symmetric_eigenvalues(m).minCoeff();
}

/// Smallest value of u^T a u / u^T b u over all u.
double smallest_ratio(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  if (a.size() == 1) return b(0, 0) > 0 ? a(0, 0) / b(0, 0) : 0;
  if (smallest_eigenvalue(b) <= 1e-12 * b.trace()) return 0;
  return symmetric_eigenvalues(a, b).minCoeff();
}

bool periodic(const Term& t) { return t.effect.numbers.contains("order"); }

/// The effect's parameter to which a coefficient corresponds.
std::string parameter_of(const Term& t, Eigen::Index column) {
  Effect filled = t.effect;
  t.fill(filled, Eigen::VectorXd::Unit(t.size(), column));
  if (periodic(t)) return "amplitude";
  for (const auto& [name, value] : filled.numbers)
    if (value != t.effect.number(name)) return name;
  return "";
}

/// Whether two effects are the same cause, regardless of size, time constant and time.
bool same_but_for_time(const Effect& a, const Effect& b) {
  return a.type == b.type && a.choices == b.choices && a.number_or("order", 0) == b.number_or("order", 0);
}

bool scanned(const Term& t) { return t.step; }

double square(double x) { return x * x; }

}  // namespace

Identifiability::Identifiability(const PlannedRecord& record, const PlanOptions& options)
    : record_(record), options_(options), readings_(record.weight.sum()) {
  const Evidence& e = record.evidence;
  const double random_sigma = rms(e.random_sigma);
  information_ = reading_information(std::max(1e-3, std::hypot(e.noise, random_sigma) / e.step()));
  terms_ = named_terms(e);
  // A plan speaks of the play between motor and joint; on the encoder's other side it has the same column.
  // What the record itself must tell is not planned.
  std::erase_if(terms_, [](const Term& t) { return t.of_reference || t.shapes; });
  terms_.push_back(step_term(e, 0.5 * e.time[e.rows() - 1]));
  Eigen::Index count = 1;
  for (const Term& t : terms_) {
    first_.push_back(count);
    count += t.size();
  }
  Eigen::MatrixXd x = Eigen::MatrixXd::Ones(e.rows(), count);
  for (std::size_t i = 0; i < terms_.size(); ++i)
    x.middleCols(first_[i], terms_[i].size()) = terms_[i].columns.matrix() / e.step();
  peak_ = x.cwiseAbs().colwise().maxCoeff();
  normal_ = x.transpose() * record.weight.matrix().asDiagonal() * x;
}

std::vector<Identifiability::Coefficients> Identifiability::parameters_of(std::size_t term) const {
  const Eigen::Index size = terms_[term].size();
  if (periodic(terms_[term])) return {{term, first_[term], size}};
  std::vector<Coefficients> list;
  for (Eigen::Index i = 0; i < size; ++i) list.push_back({term, first_[term] + i, 1});
  return list;
}

/// Block of the normal matrix after projection on the orthogonal complement of the constant (if the encoder's
/// zero is free) and of another term's columns.
/// @param other  terms_.size(): none
Eigen::MatrixXd Identifiability::remaining_normal(const Coefficients& parameter, std::size_t other) const {
  const Eigen::MatrixXd own = normal_.block(parameter.first, parameter.first, parameter.size, parameter.size);
  std::vector<Eigen::Index> columns;
  if (!record_.evidence.encoder.zero_known) columns.push_back(0);
  if (other < terms_.size())
    for (Eigen::Index i = 0; i < terms_[other].size(); ++i) columns.push_back(first_[other] + i);
  if (columns.empty()) return own;
  Eigen::MatrixXd others = normal_(columns, columns);
  Eigen::MatrixXd across = normal_(columns, Eigen::seqN(parameter.first, parameter.size));
  // Scaled to unit diagonal: the threshold of the rank must not depend on units.
  const Eigen::VectorXd scale =
      others.diagonal().cwiseSqrt().unaryExpr([](double d) { return d > 0 ? 1 / d : 1; });
  others = scale.asDiagonal() * others * scale.asDiagonal();
  across = scale.asDiagonal() * across;
  Eigen::MatrixXd remaining = own - across.transpose() * least_norm_solution(others, across, 1e-10);
  // Rounding errors.
  if (remaining.trace() < 1e-9 * own.trace()) remaining.setZero();
  return remaining;
}

/// Twice the log-likelihood ratio above which `diagnose` selects a term: the significance level divided by
/// the number of hypotheses (Bonferroni), its threshold for candidates, and the Bayesian criterion.
double Identifiability::selection_threshold(const Term& t) const {
  const auto size = static_cast<double>(t.size());
  const double tests = static_cast<double>(terms_.size()) * (scanned(t) ? scanned_hypotheses : 1);
  return std::max({chi_squared_tail_quantile(options_.alpha / tests, size), 2 * worth_trying,
                   2 * worth_a_term + size * std::log(readings_)});
}

/// Size at which the rms of the contribution reaches the smallest reported one.
/// @param about_mean  the rms about the mean, as the mean alone may be due to an offset
double Identifiability::reportable_size(const Coefficients& parameter, bool about_mean) const {
  const Term& t = terms_[parameter.term];
  const double least = (scanned(t) ? 2 : 1) * options_.least_amplitude;
  const Eigen::MatrixXd square =
      normal_.block(parameter.first, parameter.first, parameter.size, parameter.size) / readings_;
  const Eigen::VectorXd mean = normal_.block(parameter.first, 0, parameter.size, 1) / readings_;
  const bool centred = (about_mean && !t.constant) || !record_.evidence.encoder.zero_known;
  const double variance = smallest_eigenvalue(centred ? square - mean * mean.transpose() : square);
  return variance > 1e-9 * square.trace() ? least / std::sqrt(variance) : infinite;
}

PlannedEffect Identifiability::planned_effect(const Coefficients& parameter) const {
  const Term& t = terms_[parameter.term];
  PlannedEffect p;
  p.effect = t.effect;
  p.parameter = parameter_of(t, parameter.first - first_[parameter.term]);
  if (scanned(t)) p.effect.numbers.erase("time");
  p.counts_per_size = periodic(t) ? 1 / record_.evidence.step() : peak_[parameter.first];
  const double need =
      noncentrality_for_power(selection_threshold(t), static_cast<double>(t.size()), options_.power);
  const double information =
      information_.position * smallest_eigenvalue(remaining_normal(parameter, terms_.size()));
  // The estimated size must exceed the smallest reported one with the same power.
  const double deviations = normal_quantile(options_.power);
  if (information <= 0) return p;
  const double significant = std::sqrt(need / information), margin = deviations / std::sqrt(information);
  p.detectable = std::max(significant, reportable_size(parameter, false) + margin);
  p.identifiable = std::max(p.detectable, reportable_size(parameter, true) + margin);
  // Only whole counts are lost.
  if (scanned(t)) p.detectable = std::max(1.0, std::ceil(p.detectable - 1e-9));
  for (std::size_t other = 0; other < terms_.size(); ++other) {
    if (other == parameter.term || same_but_for_time(t.effect, terms_[other].effect)) continue;
    CorrelatedEffect c = correlated_effect(parameter, other);
    if (square(c.correlation) <= worth_comparing) continue;
    p.identifiable = std::max(p.identifiable, c.separable_from);
    p.correlated.push_back(std::move(c));
  }
  if (scanned(t)) p.identifiable = std::max(p.detectable, std::ceil(p.identifiable - 1e-9));
  return p;
}

CorrelatedEffect Identifiability::correlated_effect(const Coefficients& parameter, std::size_t other) const {
  const Term &t = terms_[parameter.term], &o = terms_[other];
  CorrelatedEffect r;
  r.effect = o.effect;
  if (scanned(o)) r.effect.numbers.erase("time");
  const Eigen::MatrixXd remaining = remaining_normal(parameter, other);
  const double reproduced =
      1 - std::clamp(smallest_ratio(remaining, remaining_normal(parameter, terms_.size())), 0.0, 1.0);
  r.correlation = std::sqrt(reproduced);
  r.record = record_advice(t.effect.type, o.effect.type);
  if (reproduced > similar_part) return r;
  const double penalty = static_cast<double>(t.size() - o.size()) * std::log(readings_);
  const double need = noncentrality_for_power(std::max(4.0, 2 * indistinguishable_loss + penalty),
                                              static_cast<double>(t.size()), options_.power);
  r.separable_from = std::sqrt(need / (information_.position * smallest_eigenvalue(remaining)));
  return r;
}

std::vector<PlannedEffect> Identifiability::effects() const {
  std::vector<PlannedEffect> list;
  for (std::size_t i = 0; i < terms_.size(); ++i) {
    std::vector<PlannedEffect> by_parameter;
    for (const Coefficients& parameter : parameters_of(i)) by_parameter.push_back(planned_effect(parameter));
    // Of several parameters the one that is identifiable from the largest size.
    list.push_back(
        *std::max_element(by_parameter.begin(), by_parameter.end(), [](const auto& a, const auto& b) {
          return std::pair(a.identifiable_counts(), a.detectable_counts()) <
                 std::pair(b.identifiable_counts(), b.detectable_counts());
        }));
  }
  return list;
}

}  // namespace qerr
