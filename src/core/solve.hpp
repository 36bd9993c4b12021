#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>

/// Dense decompositions of dynamic size, compiled once.
namespace qerr {

/// Inverse of a square, regular matrix, by LU decomposition with partial pivoting.
Eigen::MatrixXd inverse(const Eigen::MatrixXd&);

/// Numerical rank, by complete orthogonal decomposition.
Eigen::Index rank(const Eigen::MatrixXd&);

/// LDL^T decomposition of a symmetric positive semidefinite matrix, for several right-hand sides. Copies
/// share the (immutable) decomposition.
class SymmetricFactor {
 public:
  SymmetricFactor() = default;  ///< to be assigned before use
  explicit SymmetricFactor(const Eigen::MatrixXd&);

  Eigen::VectorXd solve(const Eigen::VectorXd&) const;
  Eigen::MatrixXd solve_columns(const Eigen::MatrixXd&) const;

 private:
  struct Decomposition;
  std::shared_ptr<const Decomposition> decomposition_;
};

/// Solution of A x = b with a symmetric positive semidefinite A, by LDL^T decomposition.
Eigen::VectorXd solve_symmetric(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

/// Inverse of a symmetric positive definite matrix, by LDL^T decomposition.
Eigen::MatrixXd symmetric_inverse(const Eigen::MatrixXd&);

/// Least-squares solution of A X = B of least norm, by complete orthogonal decomposition; 0 of an empty A.
/// @param threshold  relative size below which a pivot counts as zero; by default a few rounding errors
Eigen::MatrixXd least_norm_solution(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b,
                                    std::optional<double> threshold = {});

/// Orthonormal basis of the column space of a matrix with full column rank, by Householder reflections.
Eigen::MatrixXd orthonormal_basis(const Eigen::MatrixXd&);

/// The rotation whose third column is the unit vector along `axis`: the shortest turn of z to it.
Eigen::Matrix3d frame_of_axis(const Eigen::Vector3d& axis);

struct SymmetricEigen {
  Eigen::VectorXd values;   ///< ascending
  Eigen::MatrixXd vectors;  ///< one per column, of unit length
};

SymmetricEigen symmetric_eigen(const Eigen::MatrixXd&);

/// Ascending.
Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd&);

/// The lambda of A u = lambda B u with symmetric A and symmetric positive definite B, ascending.
Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

}  // namespace qerr
