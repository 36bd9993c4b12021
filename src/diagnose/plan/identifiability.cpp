#include "diagnose/plan/identifiability.hpp"

#include <algorithm>
#include <cmath>

#include "core/probability.hpp"
#include "core/solve.hpp"
#include "core/statistics.hpp"
#include "diagnose/inference/model_choice.hpp"
#include "diagnose/terms/scan.hpp"
#include "diagnose/verdict/record_advice.hpp"

namespace qerr {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

double least_eigenvalue(const Eigen::MatrixXd& m) {
  return m.size() == 1 ? m(0, 0) : symmetric_eigenvalues(m).minCoeff();
}

/// Least of u^T a u / u^T b u.
double least_ratio(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  if (a.size() == 1) return b(0, 0) > 0 ? a(0, 0) / b(0, 0) : 0;
  if (least_eigenvalue(b) <= 1e-12 * b.trace()) return 0;
  return symmetric_eigenvalues(a, b).minCoeff();
}

bool periodic(const Term& t) { return t.effect.numbers.contains("order"); }

/// The parameter that a coefficient is.
std::string parameter_of(const Term& t, Eigen::Index column) {
  Effect filled = t.effect;
  t.fill(filled, Eigen::VectorXd::Unit(t.size(), column));
  if (periodic(t)) return "amplitude";
  for (const auto& [name, value] : filled.numbers)
    if (value != t.effect.number(name)) return name;
  return "";
}

bool scanned(const Term& t) { return t.effect.type == "missed_counts"; }

double square(double x) { return x * x; }

}  // namespace

Sight::Sight(const PlannedRecord& record, const PlanOptions& options)
    : record_(record), options_(options), readings_(record.weight.sum()) {
  const Evidence& e = record.evidence;
  const double random_sigma = rms(e.random_sigma);
  information_ = reading_information(std::max(1e-3, std::hypot(e.noise, random_sigma) / e.step()));
  terms_ = named_terms(e);
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

std::vector<Sight::Face> Sight::faces(std::size_t term) const {
  const Eigen::Index size = terms_[term].size();
  if (periodic(terms_[term])) return {{term, first_[term], size}};
  std::vector<Face> list;
  for (Eigen::Index i = 0; i < size; ++i) list.push_back({term, first_[term] + i, 1});
  return list;
}

/// Normal matrix of a face less what the constant (of an encoder whose zero is free) and another term can
/// make of it. `other` beyond the last: no other.
Eigen::MatrixXd Sight::beyond(const Face& f, std::size_t other) const {
  const Eigen::MatrixXd own = normal_.block(f.first, f.first, f.size, f.size);
  std::vector<Eigen::Index> columns;
  if (!record_.evidence.encoder.zero_known) columns.push_back(0);
  if (other < terms_.size())
    for (Eigen::Index i = 0; i < terms_[other].size(); ++i) columns.push_back(first_[other] + i);
  if (columns.empty()) return own;
  Eigen::MatrixXd others = normal_(columns, columns);
  Eigen::MatrixXd across = normal_(columns, Eigen::seqN(f.first, f.size));
  // Units must not decide what is small.
  const Eigen::VectorXd scale =
      others.diagonal().cwiseSqrt().unaryExpr([](double d) { return d > 0 ? 1 / d : 1; });
  others = scale.asDiagonal() * others * scale.asDiagonal();
  across = scale.asDiagonal() * across;
  Eigen::MatrixXd left = own - across.transpose() * least_norm_solution(others, across, 1e-10);
  // What is left of rounding is nothing.
  if (left.trace() < 1e-9 * own.trace()) left.setZero();
  return left;
}

/// What twice the log-likelihood ratio must exceed for the term to be chosen.
double Sight::threshold(const Term& t) const {
  const auto size = static_cast<double>(t.size());
  const double tests = static_cast<double>(terms_.size()) * (scanned(t) ? scanned_hypotheses : 1);
  return std::max({chi_squared_tail_quantile(options_.alpha / tests, size), 2 * worth_trying,
                   2 * worth_a_term + size * std::log(readings_)});
}

/// Size at which what it adds is loud enough: its rms, and for a name of its own its rms about its mean,
/// which may be an offset's.
double Sight::floor_of(const Face& f, bool own_name) const {
  const Term& t = terms_[f.term];
  const double least = (scanned(t) ? 2 : 1) * options_.least_amplitude;
  const Eigen::MatrixXd square = normal_.block(f.first, f.first, f.size, f.size) / readings_;
  const Eigen::VectorXd mean = normal_.block(f.first, 0, f.size, 1) / readings_;
  const bool centred = (own_name && t.effect.type != "offset") || !record_.evidence.encoder.zero_known;
  const double variance = least_eigenvalue(centred ? square - mean * mean.transpose() : square);
  return variance > 1e-9 * square.trace() ? least / std::sqrt(variance) : infinite;
}

PlannedEffect Sight::seen_by(const Face& f) const {
  const Term& t = terms_[f.term];
  PlannedEffect p;
  p.effect = t.effect;
  p.parameter = parameter_of(t, f.first - first_[f.term]);
  if (scanned(t)) p.effect.numbers.erase("time");
  p.counts_per_size = periodic(t) ? 1 / record_.evidence.step() : peak_[f.first];
  const double need = noncentrality_for_power(threshold(t), static_cast<double>(t.size()), options_.power);
  const double information = information_.position * least_eigenvalue(beyond(f, terms_.size()));
  // What is estimated of a size scatters, and must be loud enough all the same.
  const double surely = normal_quantile(options_.power);
  if (information <= 0) return p;
  const double from = std::sqrt(need / information), scatter = surely / std::sqrt(information);
  p.seen = std::max(from, floor_of(f, false) + scatter);
  p.named = std::max(p.seen, floor_of(f, true) + scatter);
  // Counts are lost whole.
  if (scanned(t)) p.seen = std::max(1.0, std::ceil(p.seen - 1e-9));
  for (std::size_t other = 0; other < terms_.size(); ++other) {
    if (other == f.term || same_but_for_time(t.effect, terms_[other].effect)) continue;
    Rival r = rival_of(f, other);
    if (square(r.correlation) <= worth_comparing) continue;
    p.named = std::max(p.named, r.size);
    p.rivals.push_back(std::move(r));
  }
  if (scanned(t)) p.named = std::max(p.seen, std::ceil(p.named - 1e-9));
  return p;
}

Rival Sight::rival_of(const Face& f, std::size_t other) const {
  const Term &t = terms_[f.term], &o = terms_[other];
  Rival r;
  r.effect = o.effect;
  if (scanned(o)) r.effect.numbers.erase("time");
  const Eigen::MatrixXd left = beyond(f, other);
  const double part = 1 - std::clamp(least_ratio(left, beyond(f, terms_.size())), 0.0, 1.0);
  r.correlation = std::sqrt(part);
  r.record = record_advice(t.effect.type, o.effect.type);
  if (part > nearly_as_good) return r;
  const double price = static_cast<double>(t.size() - o.size()) * std::log(readings_);
  const double need = noncentrality_for_power(std::max(4.0, 2 * cannot_be_told + price),
                                              static_cast<double>(t.size()), options_.power);
  r.size = std::sqrt(need / (information_.position * least_eigenvalue(left)));
  return r;
}

std::vector<PlannedEffect> Sight::effects() const {
  std::vector<PlannedEffect> list;
  for (std::size_t i = 0; i < terms_.size(); ++i) {
    std::vector<PlannedEffect> sides;
    for (const Face& f : faces(i)) sides.push_back(seen_by(f));
    // Of several parameters the one that is hardest to name.
    list.push_back(*std::max_element(sides.begin(), sides.end(), [](const auto& a, const auto& b) {
      return std::pair(a.named_counts(), a.seen_counts()) < std::pair(b.named_counts(), b.seen_counts());
    }));
  }
  return list;
}

}  // namespace qerr
