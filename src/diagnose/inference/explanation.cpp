#include "diagnose/inference/explanation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/solve.hpp"
#include "diagnose/record/with_effects.hpp"
#include "diagnose/search/linear_model.hpp"

namespace qerr {

namespace {

constexpr Eigen::Index most_blocks = 64;  ///< of the variance inflation (convention)

}  // namespace

Explanation::Explanation(const Evidence& e, std::vector<Term> terms) : evidence_(&e) {
  const double below = below_reading(e.encoder);
  intervals_.lower = e.measured - below * e.step() - e.path;
  intervals_.upper = intervals_.lower + e.step();
  base_.resize(e.rows(), e.encoder.zero_known ? 0 : 1);
  base_.setOnes();
  beta_ = Eigen::VectorXd::Zero(base_.cols());
  spread_ = 2 * (e.measured - e.path).abs().maxCoeff() + e.step();
  const double residual_noise = std::max(e.path_noise, 1e-3 * e.step());
  relative_.setOnes(e.rows());
  if (e.random_sigma.size() > 0) relative_ = (1 + (e.random_sigma / residual_noise).square()).sqrt();
  for (Term& t : terms) add(std::move(t));
  fit();
}

void Explanation::add(Term term) {
  beta_.conservativeResize(beta_.size() + term.size());
  beta_.tail(term.size()).setZero();
  terms_.push_back(std::move(term));
}

Eigen::Index Explanation::first_coefficient(std::size_t term) const {
  Eigen::Index first = base_.cols();
  for (std::size_t i = 0; i < term; ++i) first += terms_[i].size();
  return first;
}

void Explanation::remove(std::size_t term) {
  const Eigen::Index first = first_coefficient(term), size = terms_[term].size();
  Eigen::VectorXd kept(beta_.size() - size);
  kept << beta_.head(first), beta_.tail(beta_.size() - first - size);
  beta_ = kept;
  terms_.erase(terms_.begin() + static_cast<std::ptrdiff_t>(term));
}

Eigen::VectorXd Explanation::coefficients(std::size_t term) const {
  return beta_.segment(first_coefficient(term), terms_[term].size());
}

double Explanation::mean_offset() const {
  for (std::size_t i = 0; i < terms_.size(); ++i)
    if (terms_[i].constant) return coefficients(i)[0];
  return 0;
}

double Explanation::variance_inflation(const Eigen::ArrayXXd& columns) const {
  const Eigen::MatrixXd scores = likelihood_.score.matrix().asDiagonal() * columns.matrix();
  const Eigen::Index blocks = std::min(most_blocks, scores.rows() / 8);
  if (blocks < 4) return 1;
  Eigen::MatrixXd by_block(blocks, scores.cols());
  for (Eigen::Index i = 0; i < blocks; ++i) {
    const Eigen::Index first = i * scores.rows() / blocks, last = (i + 1) * scores.rows() / blocks;
    by_block.row(i) = scores.middleRows(first, last - first).colwise().sum();
  }
  return std::max(1.0, by_block.squaredNorm() / std::max(scores.squaredNorm(), 1e-300));
}

namespace {

constexpr double log_likelihood_tolerance = 1e-3;  ///< log-likelihood gain at which the iteration ends

/// Gain that a whole step promises below which none is tried: near the rounding of the likelihood no length
/// of a step raises it.
constexpr double least_promised_gain = 1e-9;

constexpr int most_newton_steps = 60;

}  // namespace

IntervalLikelihood Explanation::at(const Eigen::VectorXd& unit, double sigma, double outliers) const {
  const Eigen::ArrayXd x = fixed_ + (columns_ * unit).array();
  return interval_likelihood(intervals_, x, sigma * relative_, outliers, spread_);
}

/// Lower limit of the noise: half of the path's, which is an estimate, or a thousandth of a count
/// (conventions).
double Explanation::least_noise() const {
  return std::max(0.5 * evidence_->path_noise, 1e-3 * evidence_->step());
}

/// Start of Newton's method: least squares to the middles of the intervals, and the scatter about them.
void Explanation::initialize(Eigen::VectorXd& unit) {
  const Eigen::ArrayXd weight = relative_.square().inverse();
  const Eigen::VectorXd middle = (0.5 * (intervals_.lower + intervals_.upper) - fixed_).matrix();
  Eigen::ArrayXd residual = middle.array();
  if (columns_.cols() > 0) {
    const Eigen::Index n = columns_.cols();
    const Eigen::MatrixXd gram = weighted_gram(columns_, middle, weight.matrix());
    Eigen::MatrixXd normal = gram.topLeftCorner(n, n);
    normal.diagonal().array() += 1e-10 * normal.diagonal().mean();
    unit = solve_symmetric(normal, gram.col(n).head(n));
    residual -= (columns_ * unit).array();
  }
  sigma_ = std::clamp(std::sqrt((residual.square() * weight).mean()), least_noise(), spread_);
}

/// Newton's method in coefficients/sigma and 1/sigma, in which the log-likelihood is concave. With outliers
/// each step maximizes for the present outlier probabilities (EM), starting from the fit without outliers:
/// the local optimum with little noise and many outliers is not the one sought.
void Explanation::maximize(Eigen::VectorXd& unit, double outliers) {
  const Eigen::Index n = unit.size();
  likelihood_ = at(unit, sigma_, outliers);
  for (int i = 0; i < most_newton_steps; ++i) {
    // In units of the present sigma: x = sigma u, w = 1.
    Eigen::MatrixXd hessian(n + 1, n + 1);
    Eigen::VectorXd gradient(n + 1);
    const Eigen::MatrixXd gram =
        weighted_gram(columns_, likelihood_.score.matrix(), likelihood_.curvature.matrix());
    hessian.topLeftCorner(n, n) = gram.topLeftCorner(n, n);
    hessian.col(n).head(n) = columns_.transpose() * likelihood_.cross.matrix();
    hessian.row(n).head(n) = hessian.col(n).head(n).transpose();
    hessian(n, n) = likelihood_.scale_curvature;
    gradient << columns_.transpose() * likelihood_.score.matrix(), likelihood_.scale_score;
    const bool least = sigma_ <= least_noise() * 1.0000001 && likelihood_.scale_score > 0;
    const Eigen::Index free = least ? n : n + 1;
    if (free == 0) break;
    Eigen::VectorXd scale = hessian.diagonal().head(free).cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    Eigen::MatrixXd normal = scale.asDiagonal() * hessian.topLeftCorner(free, free) * scale.asDiagonal();
    normal.diagonal().array() += 1e-10;
    Eigen::VectorXd step = Eigen::VectorXd::Zero(n + 1);
    step.head(free) = scale.asDiagonal() * solve_symmetric(normal, scale.asDiagonal() * gradient.head(free));
    if (0.5 * step.head(free).dot(gradient.head(free)) < least_promised_gain) break;
    const double before = likelihood_.log_likelihood;
    bool better = false;
    for (double length = 1; length > 1e-4 && !better; length /= 3) {
      const double w = std::clamp(1 + length * step[n], 0.2, 5.0);
      const Eigen::VectorXd moved = (unit + length * step.head(n)) / w;
      const double sigma = std::clamp(sigma_ / w, least_noise(), spread_);
      IntervalLikelihood next = at(moved, sigma, outliers);
      if (!(next.log_likelihood >= before)) continue;
      better = true;
      unit = moved, sigma_ = sigma;
      likelihood_ = std::move(next);
    }
    if (!better || likelihood_.log_likelihood - before < log_likelihood_tolerance) break;
  }
}

/// Columns of all terms, scaled to unit norm.
Eigen::VectorXd Explanation::assemble_columns() {
  Eigen::Index count = base_.cols();
  for (const Term& t : terms_) count += t.size();
  columns_.resize(evidence_->rows(), count);
  columns_.leftCols(base_.cols()) = base_.matrix();
  fixed_.setZero(evidence_->rows());
  for (std::size_t i = 0; i < terms_.size(); ++i) {
    columns_.middleCols(first_coefficient(i), terms_[i].size()) = terms_[i].columns.matrix();
    if (terms_[i].fixed.size() > 0) fixed_ += terms_[i].fixed;
  }
  Eigen::VectorXd scale = columns_.colwise().norm();
  for (double& s : scale) s = s > 0 ? s : 1;
  columns_ *= scale.cwiseInverse().asDiagonal();
  return scale;
}

/// Fits with the present columns and without outliers.
void Explanation::fit_plainly() {
  const Eigen::VectorXd scale = assemble_columns();
  Eigen::VectorXd unit = Eigen::VectorXd::Zero(columns_.cols());
  initialize(unit);
  maximize(unit, 0);
  beta_ = unit.cwiseQuotient(scale);
}

/// What the other terms add to the position on which a term depends [rad or m].
Eigen::ArrayXd Explanation::moved_before(std::size_t term) const {
  Eigen::ArrayXd moved = Eigen::ArrayXd::Zero(evidence_->rows());
  for (std::size_t k = 0; k < terms_.size(); ++k)
    if (k != term && displaces(terms_[k], terms_[term])) moved += qerr::addition(terms_[k], coefficients(k));
  return moved;
}

/// Recomputes terms along the path displaced by the preceding terms, which matters for displacements of many
/// counts.
/// @return whether a linear term changed by more than a tenth of the noise
bool Explanation::follow_path() {
  constexpr double negligible = 0.1;  // of the noise
  std::vector<Eigen::ArrayXd> before(terms_.size());
  for (std::size_t k = 0; k < terms_.size(); ++k)
    if (terms_[k].along) before[k] = moved_before(k);
  bool any = false;
  for (std::size_t k = 0; k < terms_.size(); ++k) {
    if (!terms_[k].along) continue;
    const Eigen::ArrayXd& moved = before[k];
    if (terms_[k].relinearized) {
      terms_[k] = terms_[k].along(*evidence_, terms_[k], moved);
      continue;  // it is linearized again after the fit
    }
    Term next = terms_[k].along(*evidence_, terms_[k], moved);
    const Eigen::ArrayXd change =
        qerr::addition(next, coefficients(k)) - qerr::addition(terms_[k], coefficients(k));
    if (change.abs().maxCoeff() < negligible * sigma_) continue;
    any = true;
    terms_[k] = std::move(next);
  }
  return any;
}

/// Repeats the fit along the displaced path until the terms no longer change.
void Explanation::fit_along_path() {
  constexpr int most_iterations = 8;
  for (int i = 0; i < most_iterations && follow_path(); ++i) fit_plainly();
}

/// Gauss-Newton iteration of the non-linear terms; a step that increases the residual is halved.
void Explanation::fit_nonlinear() {
  constexpr int most_iterations = 25;
  constexpr double enough = 0.02;
  if (std::none_of(terms_.begin(), terms_.end(), [](const Term& t) { return t.relinearized; })) return;
  const Eigen::ArrayXd middle = 0.5 * (intervals_.lower + intervals_.upper);
  Eigen::VectorXd good = beta_;
  double least = std::numeric_limits<double>::infinity(), before = likelihood_.log_likelihood;
  for (int i = 0; i < most_iterations; ++i) {
    follow_path();
    for (std::size_t k = 0; k < terms_.size(); ++k)
      if (terms_[k].relinearized) terms_[k] = terms_[k].relinearized(*evidence_, terms_[k], coefficients(k));
    const Eigen::VectorXd scale = assemble_columns();
    const double squares = (middle - fixed_ - (columns_ * beta_.cwiseProduct(scale)).array()).square().sum();
    if (squares > 1.0001 * least) {
      beta_ = 0.5 * (beta_ + good);
      continue;
    }
    least = squares, good = beta_;
    fit_plainly();
    if (std::abs(likelihood_.log_likelihood - before) < enough) return;
    before = likelihood_.log_likelihood;
  }
}

void Explanation::fit() {
  fit_plainly();
  fit_along_path();
  fit_nonlinear();
  const Eigen::VectorXd scale = assemble_columns();
  Eigen::VectorXd unit = beta_.cwiseProduct(scale);
  maximize(unit, outlier_part);
  x_ = fixed_ + (columns_ * unit).array();
  beta_ = unit.cwiseQuotient(scale);
}

}  // namespace qerr
