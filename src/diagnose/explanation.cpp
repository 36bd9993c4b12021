#include "explanation.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>

namespace qerr {

namespace {

constexpr Eigen::Index most_blocks = 64;

Eigen::ArrayXd constant(double value) { return Eigen::ArrayXd::Constant(1, value); }

}  // namespace

Explanation::Explanation(const Evidence& e) : evidence_(&e), x_(e.reference) {
  const double below = e.encoder.rounding == Rounding::down ? 0.0 : 0.5;
  intervals_.lower = e.measured - below * e.step();
  intervals_.upper = e.measured + (1 - below) * e.step();
  base_.resize(e.rows(), e.encoder.zero_known ? 0 : 1);
  base_.setOnes();
  beta_ = Eigen::VectorXd::Zero(base_.cols());
  sigma_ = std::max(std::sqrt((e.measured - e.reference).square().mean()), e.step());
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

void Explanation::place() { likelihood_ = interval_likelihood(intervals_, x_, constant(sigma_)); }

/// One step on log sigma towards where the likelihood is largest, by bisection of its slope.
void Explanation::fit_noise() {
  const double least = std::max({0.5 * evidence_->noise, 0.3 * evidence_->grid, 1e-3 * evidence_->step()});
  double low = std::log(least), high = std::log(std::max(4 * sigma_, 4 * least));
  const auto slope = [&](double log_sigma) {
    return interval_likelihood(intervals_, x_, constant(std::exp(log_sigma))).scale_score;
  };
  if (slope(low) <= 0) {
    sigma_ = least;
  } else {
    for (int i = 0; i < 12; ++i) {
      const double middle = 0.5 * (low + high);
      (slope(middle) > 0 ? low : high) = middle;
    }
    sigma_ = std::exp(0.5 * (low + high));
  }
  place();
}

void Explanation::fit() {
  const Eigen::MatrixXd columns = all_columns().matrix();
  Eigen::VectorXd scale = columns.colwise().norm();
  for (double& s : scale) s = s > 0 ? s : 1;
  const Eigen::MatrixXd unit = columns * scale.cwiseInverse().asDiagonal();
  Eigen::VectorXd b = beta_.cwiseProduct(scale);
  const auto moved = [&](const Eigen::VectorXd& at) -> Eigen::ArrayXd {
    return evidence_->reference + (unit * at).array();
  };
  x_ = moved(b);
  fit_noise();
  for (int i = 0; i < 40 && unit.cols() > 0; ++i) {
    const double before = likelihood_.log_likelihood;
    const Eigen::VectorXd gradient = unit.transpose() * likelihood_.score.matrix();
    Eigen::MatrixXd hessian = unit.transpose() * likelihood_.curvature.matrix().asDiagonal() * unit;
    hessian.diagonal().array() += 1e-9 * hessian.diagonal().mean() + 1e-12;
    const Eigen::VectorXd step = hessian.ldlt().solve(gradient);
    double length = 1;
    Eigen::VectorXd next = b + step;
    while (length > 1e-3) {
      next = b + length * step;
      if (qerr::log_likelihood(intervals_, moved(next), constant(sigma_)) >= before - 1e-9) break;
      length /= 2;
    }
    b = next;
    x_ = moved(b);
    fit_noise();
    if (likelihood_.log_likelihood - before < 1e-3) break;
  }
  beta_ = b.cwiseQuotient(scale);
}

ScoreTest Explanation::test(const Eigen::ArrayXXd& columns) const {
  const Eigen::MatrixXd present = all_columns().matrix();
  const Eigen::VectorXd weights = likelihood_.curvature.matrix();
  Eigen::MatrixXd extra = columns.matrix();
  const Eigen::Index p = extra.cols();
  if (present.cols() > 0) {
    const Eigen::MatrixXd weighted = weights.asDiagonal() * present;
    Eigen::MatrixXd normal = present.transpose() * weighted;
    normal.diagonal().array() *= 1 + 1e-10;
    extra -= present * normal.ldlt().solve(weighted.transpose() * extra);
  }
  // Nothing is left of a column that the model already has.
  const Eigen::VectorXd before = columns.matrix().colwise().norm(), after = extra.colwise().norm();
  for (Eigen::Index c = 0; c < p; ++c)
    if (!(after[c] > 1e-6 * before[c])) return {};
  const Eigen::MatrixXd scores = likelihood_.score.matrix().asDiagonal() * extra;
  const Eigen::VectorXd sum = scores.colwise().sum().transpose();
  Eigen::MatrixXd information = extra.transpose() * weights.asDiagonal() * extra;
  information.diagonal().array() *= 1 + 1e-10;
  ScoreTest test;
  test.gain = 0.5 * sum.dot(information.ldlt().solve(sum));

  const Eigen::Index blocks = std::min(most_blocks, scores.rows() / 8);
  if (blocks <= p + 2) return test;
  Eigen::MatrixXd by_block(blocks, p);
  for (Eigen::Index i = 0; i < blocks; ++i) {
    const Eigen::Index first = i * scores.rows() / blocks, last = (i + 1) * scores.rows() / blocks;
    by_block.row(i) = scores.middleRows(first, last - first).colwise().sum();
  }
  by_block.rowwise() -= by_block.colwise().mean();
  const Eigen::MatrixXd covariance = by_block.transpose() * by_block;
  // Hotelling's T^2 of the blocks' scores.
  const double dof = static_cast<double>(blocks - p);
  const double f = sum.dot(covariance.completeOrthogonalDecomposition().solve(sum)) * dof /
                   static_cast<double>(p * blocks);
  if (std::isfinite(f))
    test.p_value = cdf(complement(boost::math::fisher_f(static_cast<double>(p), dof), std::max(0.0, f)));
  return test;
}

}  // namespace qerr
