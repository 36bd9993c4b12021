#include "diagnose/inference/explanation.hpp"

#include <algorithm>
#include <cmath>

#include "diagnose/inference/weighted_square.hpp"

namespace qerr {

namespace {

constexpr Eigen::Index most_blocks = 64;  ///< of the variance inflation (convention)

}  // namespace

Explanation::Explanation(const Evidence& e) : evidence_(&e) {
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

double Explanation::gain(const Term& t) const {
  Eigen::MatrixXd extra = t.columns.matrix();
  if (t.fixed.size() > 0) {
    extra.conservativeResize(Eigen::NoChange, extra.cols() + 1);
    extra.rightCols(1) = t.fixed.matrix();
  }
  Eigen::MatrixXd information = weighted_square(extra, plain_.curvature);
  const Eigen::VectorXd alone = information.diagonal();
  Eigen::VectorXd score = extra.transpose() * plain_.score.matrix();
  if (columns_.cols() > 0) {
    const Eigen::MatrixXd shared = weighted_.transpose() * extra;
    information -= shared.transpose() * present_.solve_columns(shared);
    score -= shared.transpose() * present_.solve(columns_.transpose() * plain_.score.matrix());
  }
  // The gain of a column in the span of the model is zero.
  if ((information.diagonal().array() <= 1e-9 * alone.array()).any()) return 0;
  information.diagonal().array() *= 1 + 1e-10;
  return 0.5 * score.dot(solve_symmetric(information, score));
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

}  // namespace qerr
