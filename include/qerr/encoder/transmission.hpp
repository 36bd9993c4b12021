#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "qerr/encoder/encoder.hpp"

namespace qerr {

/// A square matrix that is mostly the identity, which takes no memory: robots of thousands of joints have it.
class Coupling {
 public:
  Coupling() = default;  ///< 0 x 0
  static Coupling identity(Eigen::Index size);
  template <class Derived>
  Coupling(const Eigen::MatrixBase<Derived>& matrix)  // NOLINT: a matrix is a coupling
      : size_(matrix.rows()), matrix_(matrix) {
    if (matrix_.isIdentity(0)) matrix_.resize(0, 0);
  }

  Eigen::Index size() const { return size_; }
  bool is_identity() const { return matrix_.size() == 0; }
  double operator()(Eigen::Index row, Eigen::Index column) const {
    return is_identity() ? static_cast<double>(row == column) : matrix_(row, column);
  }
  /// Copies; constant, as a change of them would change nothing.
  const Eigen::VectorXd col(Eigen::Index) const;
  const Eigen::RowVectorXd row(Eigen::Index) const;
  Eigen::MatrixXd dense() const;

  /// @pre not singular
  Coupling inverse() const;
  Coupling magnitudes() const;  ///< of the entries

  // Friends that are found by a coupling among the operands only: two matrices are no couplings.
  friend Eigen::MatrixXd operator*(const Coupling& c, const Eigen::MatrixXd& m) { return c.times(m); }
  friend Eigen::VectorXd operator*(const Coupling& c, const Eigen::VectorXd& v) { return c.times(v); }
  friend Eigen::MatrixXd operator*(const Eigen::MatrixXd& m, const Coupling& c) { return c.after(m); }

 private:
  Eigen::MatrixXd times(const Eigen::MatrixXd&) const;
  Eigen::MatrixXd after(const Eigen::MatrixXd&) const;

  Eigen::Index size_ = 0;
  Eigen::MatrixXd matrix_;  ///< empty: the identity
};

/// From encoder space to joint space: joint coordinates = coupling * (encoder angles / gear ratio).
///
/// With `coupling` = I every joint has its own encoder (the case of the paper). A differential or a joint
/// measured relative to the ground has off-diagonal entries. Joint errors are then neither uniform nor
/// independent: propagation from encoder space is exact, Eq. (9) of the paper is not.
struct Transmission {
  std::vector<Encoder>
      encoders;       ///< one per independent joint, in chain order, on the joint side of its gear
  Coupling coupling;  ///< n x n, row: joint, column: encoder; not singular
};

/// Quantization interval of every encoder, in chain order [rad or m].
Eigen::VectorXd resolutions(const Transmission&);

/// Mean error of every encoder, in chain order [rad or m].
Eigen::VectorXd mean_errors(const Transmission&);

}  // namespace qerr
