#include "core/solve.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/QR>

namespace qerr {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd inverse(const MatrixXd& m) { return m.inverse(); }

Eigen::Index rank(const MatrixXd& m) { return Eigen::CompleteOrthogonalDecomposition<MatrixXd>(m).rank(); }

struct SymmetricFactor::Decomposition : Eigen::LDLT<MatrixXd> {
  using Eigen::LDLT<MatrixXd>::LDLT;
};

SymmetricFactor::SymmetricFactor(const MatrixXd& m)
    : decomposition_(std::make_shared<const Decomposition>(m)) {}

VectorXd SymmetricFactor::solve(const VectorXd& b) const { return solve_columns(b); }
MatrixXd SymmetricFactor::solve_columns(const MatrixXd& b) const { return decomposition_->solve(b); }

VectorXd solve_symmetric(const MatrixXd& a, const VectorXd& b) { return SymmetricFactor(a).solve(b); }

MatrixXd symmetric_inverse(const MatrixXd& m) {
  return SymmetricFactor(m).solve_columns(MatrixXd::Identity(m.rows(), m.cols()));
}

MatrixXd least_norm_solution(const MatrixXd& a, const MatrixXd& b, std::optional<double> threshold) {
  if (a.size() == 0) return MatrixXd::Zero(a.cols(), b.cols());  // which Eigen does not decompose
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> decomposition;
  if (threshold) decomposition.setThreshold(*threshold);
  decomposition.compute(a);
  return decomposition.solve(b);
}

MatrixXd orthonormal_basis(const MatrixXd& m) {
  return Eigen::HouseholderQR<MatrixXd>(m).householderQ() * MatrixXd::Identity(m.rows(), m.cols());
}

Eigen::Matrix3d frame_of_axis(const Eigen::Vector3d& axis) {
  const Eigen::Vector3d to = axis.normalized();
  const Eigen::Quaterniond turn(1 + to.z(), -to.y(), to.x(),
                                0);  // twice the half angle's cosine, by z x axis
  if (turn.squaredNorm() > 1e-30) return turn.normalized().toRotationMatrix();
  return Eigen::Vector3d(1, -1, -1).asDiagonal();  // from z to -z, or within rounding of it
}

SymmetricEigen symmetric_eigen(const MatrixXd& m) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(m);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

VectorXd symmetric_eigenvalues(const MatrixXd& m) {
  return Eigen::SelfAdjointEigenSolver<MatrixXd>(m, Eigen::EigenvaluesOnly).eigenvalues();
}

VectorXd symmetric_eigenvalues(const MatrixXd& a, const MatrixXd& b) {
  return Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd>(a, b, Eigen::EigenvaluesOnly).eigenvalues();
}

}  // namespace qerr
