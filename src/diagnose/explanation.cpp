#include "explanation.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace qerr {

namespace {

constexpr Eigen::Index most_blocks = 64;
constexpr double outlier_part = 0.01;

Eigen::ArrayXd constant(double value) { return Eigen::ArrayXd::Constant(1, value); }

}  // namespace

Explanation::Explanation(const Evidence& e) : evidence_(&e), x_(e.reference) {
  const double below = e.encoder.rounding == Rounding::down ? 0.0 : 0.5;
  intervals_.lower = e.measured - below * e.step();
  intervals_.upper = e.measured + (1 - below) * e.step();
  base_.resize(e.rows(), e.encoder.zero_known ? 0 : 1);
  base_.setOnes();
  beta_ = Eigen::VectorXd::Zero(base_.cols());
  spread_ = 2 * (e.measured - e.reference).abs().maxCoeff() + e.step();
  fit();
}

Eigen::ArrayXXd Explanation::all_columns() const {
  Eigen::Index count = base_.cols();
  for (const Term& t : terms_) count += t.size();
  Eigen::ArrayXXd all(evidence_->rows(), count);
  all.leftCols(base_.cols()) = base_;
  Eigen::Index at = base_.cols();
  for (const Term& t : terms_) {
    all.middleCols(at, t.size()) = t.columns;
    at += t.size();
  }
  return all;
}

void Explanation::add(Term term) {
  beta_.conservativeResize(beta_.size() + term.size());
  beta_.tail(term.size()).setZero();
  terms_.push_back(std::move(term));
}

void Explanation::remove(std::size_t term) {
  Eigen::Index at = base_.cols();
  for (std::size_t i = 0; i < term; ++i) at += terms_[i].size();
  const Eigen::Index size = terms_[term].size(), after = beta_.size() - at - size;
  Eigen::VectorXd kept(beta_.size() - size);
  kept << beta_.head(at), beta_.tail(after);
  beta_ = kept;
  terms_.erase(terms_.begin() + static_cast<std::ptrdiff_t>(term));
}

Eigen::VectorXd Explanation::coefficients(std::size_t term) const {
  Eigen::Index at = base_.cols();
  for (std::size_t i = 0; i < term; ++i) at += terms_[i].size();
  return beta_.segment(at, terms_[term].size());
}

IntervalLikelihood Explanation::at(double sigma, double outliers) const {
  return interval_likelihood(intervals_, x_, constant(sigma), outliers, spread_);
}

/// The least noise there can be: what the reference has, or the grid of the file.
double Explanation::least_noise() const {
  return std::max({0.5 * evidence_->noise, 0.3 * evidence_->grid, 1e-3 * evidence_->step()});
}

/// From the present sigma uphill: with outliers there may be several optima, and the one with little noise
/// and a crowd of outliers is not meant.
void Explanation::climb_noise(double outliers) {
  likelihood_ = at(sigma_, outliers);
  for (double factor = 2; factor > 1.01; factor = std::sqrt(factor))
    for (const double by : {1 / factor, factor})
      while (sigma_ * by >= least_noise() && sigma_ * by <= spread_) {
        IntervalLikelihood next = at(sigma_ * by, outliers);
        if (next.log_likelihood <= likelihood_.log_likelihood) break;
        sigma_ *= by;
        likelihood_ = std::move(next);
      }
}

/// Newton's method on the coefficients, climbing in sigma between the steps.
void Explanation::maximize(const Eigen::MatrixXd& unit, Eigen::VectorXd& b, double outliers) {
  const auto moved = [&](const Eigen::VectorXd& coefficients) -> Eigen::ArrayXd {
    return evidence_->reference + (unit * coefficients).array();
  };
  x_ = moved(b);
  climb_noise(outliers);
  for (int i = 0; i < 30 && unit.cols() > 0; ++i) {
    const double before = likelihood_.log_likelihood;
    const Eigen::VectorXd gradient = unit.transpose() * likelihood_.score.matrix();
    Eigen::MatrixXd hessian = unit.transpose() * likelihood_.curvature.matrix().asDiagonal() * unit;
    hessian.diagonal().array() += 1e-9 * hessian.diagonal().mean() + 1e-12;
    const Eigen::VectorXd step = hessian.ldlt().solve(gradient);
    double length = 1;
    for (; length > 1e-3; length /= 2) {
      x_ = moved(b + length * step);
      if (at(sigma_, outliers).log_likelihood >= before - 1e-9) break;
    }
    b += length * step;
    x_ = moved(b);
    climb_noise(outliers);
    if (likelihood_.log_likelihood - before < 1e-2) break;
  }
}

void Explanation::fit() {
  const Eigen::MatrixXd columns = all_columns().matrix();
  Eigen::VectorXd scale = columns.colwise().norm();
  for (double& s : scale) s = s > 0 ? s : 1;
  const Eigen::MatrixXd unit = columns * scale.cwiseInverse().asDiagonal();
  Eigen::VectorXd b = beta_.cwiseProduct(scale);
  sigma_ = spread_ / 4;
  maximize(unit, b, 0);
  plain_ = likelihood_;
  plain_sigma_ = sigma_;
  maximize(unit, b, outlier_part);
  beta_ = b.cwiseQuotient(scale);
}

double Explanation::gain(const Eigen::ArrayXXd& columns) const {
  const Eigen::MatrixXd present = all_columns().matrix();
  const Eigen::VectorXd weights = plain_.curvature.matrix();
  Eigen::MatrixXd extra = columns.matrix();
  if (present.cols() > 0) {
    const Eigen::MatrixXd weighted = weights.asDiagonal() * present;
    Eigen::MatrixXd normal = present.transpose() * weighted;
    normal.diagonal().array() *= 1 + 1e-10;
    extra -= present * normal.ldlt().solve(weighted.transpose() * extra);
  }
  // Nothing is left of a column that the model already has.
  if (((extra.colwise().norm().array()) <= 1e-6 * columns.matrix().colwise().norm().array()).any()) return 0;
  const Eigen::VectorXd score = extra.transpose() * plain_.score.matrix();
  Eigen::MatrixXd information = extra.transpose() * weights.asDiagonal() * extra;
  information.diagonal().array() *= 1 + 1e-10;
  return 0.5 * score.dot(information.ldlt().solve(score));
}

double Explanation::inflation(const Eigen::ArrayXXd& columns) const {
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

}  // namespace qerr
