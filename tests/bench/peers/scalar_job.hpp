#pragma once

#include <memory>

#include "tally.hpp"

namespace qerr::bench {

using Matrix6X = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// The job in scalar C++ for a library that computes one configuration's Jacobian: the same code for all
/// libraries, with fixed sizes where possible and without allocations.
///
/// `Arm` is built from a Problem and has
///   const M& jacobian(const double* motions)   6 x joints, valid until the next call
///   static constexpr int linear                the first of its three linear rows: 0 or 3
template <typename Arm>
class ScalarJob {
 public:
  explicit ScalarJob(const Problem& p)
      : problem_(&p), arm_(p), folds_(!p.fold.isIdentity(0)), couples_(!p.weights.isDiagonal(0)) {
    scale_ = p.weights / std::sqrt(12.0);
    columns_.resize(6, p.weights.cols());
  }

  Summaries run(Stage stage, std::uint64_t count, Recording* recording) {
    if (stage != Stage::full) {
      for (std::uint64_t i = 0; i < count; ++i) one(stage, i, recording);
      return {};
    }
    Tally tally;
    for (std::uint64_t i = 0; i < count; ++i) {
      one(stage, i, recording);
      tally.add(i, figures_.data());
    }
    return tally.result(problem_->points);
  }

 private:
  void one(Stage stage, std::uint64_t i, Recording* recording) {
    const auto column = static_cast<Eigen::Index>(i);
    const auto& joints = arm_.jacobian(problem_->motions.data() + column * problem_->motions.rows());
    if (folds_) folded_.noalias() = joints * problem_->fold;
    observe(joints.data());
    if (recording) {
      const Matrix6X all = folds_ ? Matrix6X(folded_) : Matrix6X(joints);
      for (int row = 0; row < 6; ++row)
        for (Eigen::Index k = 0; k < all.cols(); ++k)
          recording->jacobians(6 * k + row, column) = all(their_row(row), k);
    }
    if (stage == Stage::jac) return;
    if (folds_)
      bounds(folded_);
    else
      bounds(joints);
    if (recording) {
      recording->worst_cases.col(column) = Eigen::Map<const Eigen::Matrix<double, 6, 1>>(figures_.data());
      recording->covariances.col(column) = covariance_;
    }
  }

  /// Worst case and covariance: with columns a_k of J C Delta/sqrt(12), sqrt(3) sum |a_k| and sum a_k a_k^T.
  template <typename Columns>
  void bounds(const Columns& jacobian) {
    if (couples_) columns_.noalias() = jacobian * scale_;
    Eigen::Matrix<double, 6, 6> squares = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> magnitudes = Eigen::Matrix<double, 6, 1>::Zero();
    for (Eigen::Index k = 0; k < columns_.cols(); ++k) {
      const Eigen::Matrix<double, 6, 1> a =
          couples_ ? columns_.col(k) : Eigen::Matrix<double, 6, 1>(jacobian.col(k) * scale_(k, k));
      magnitudes += a.cwiseAbs();
      squares.noalias() += a * a.transpose();
    }
    int entry = 0;
    for (int row = 0; row < 6; ++row) {
      figures_[static_cast<std::size_t>(row)] = std::sqrt(3.0) * magnitudes[their_row(row)];
      figures_[static_cast<std::size_t>(row + 6)] = std::sqrt(squares(their_row(row), their_row(row)));
      for (int c = 0; c <= row; ++c) covariance_[entry++] = squares(their_row(row), their_row(c));
    }
    observe(figures_.data());
    observe(covariance_.data());
  }

  static constexpr int their_row(int row) { return (row + Arm::linear) % 6; }

  const Problem* problem_;
  Arm arm_;
  bool folds_, couples_;
  Eigen::MatrixXd scale_;
  Matrix6X folded_, columns_;
  std::array<double, Tally::figures> figures_{};  ///< worst cases, then sigmas
  Eigen::Matrix<double, covariance_entries, 1> covariance_;
};

/// A library as a contestant: its name, how it was built, its Arm.
template <typename Arm>
Contestant scalar_contestant(std::string name, std::string built) {
  return {std::move(name), std::move(built), [](const Problem& p) -> Run {
            const auto job = std::make_shared<ScalarJob<Arm>>(p);
            return
                [job](Stage stage, std::uint64_t count, Recording* r) { return job->run(stage, count, r); };
          }};
}

}  // namespace qerr::bench
