#include "qerr/encoder/transmission.hpp"

#include "core/solve.hpp"

namespace qerr {

namespace {

template <class Function>
Eigen::VectorXd of_each(const Transmission& t, Function f) {
  Eigen::VectorXd values(std::ssize(t.encoders));
  for (Eigen::Index i = 0; i < values.size(); ++i) values[i] = f(t.encoders[i]);
  return values;
}

}  // namespace

Eigen::VectorXd resolutions(const Transmission& t) {
  return of_each(t, [](const Encoder& e) { return e.resolution; });
}

Eigen::VectorXd mean_errors(const Transmission& t) {
  return of_each(t, [](const Encoder& e) { return mean_error(e); });
}

Coupling Coupling::identity(Eigen::Index size) {
  Coupling c;
  c.size_ = size;
  return c;
}

const Eigen::VectorXd Coupling::col(Eigen::Index i) const {
  return is_identity() ? Eigen::VectorXd(Eigen::VectorXd::Unit(size_, i)) : Eigen::VectorXd(matrix_.col(i));
}

const Eigen::RowVectorXd Coupling::row(Eigen::Index i) const {
  return is_identity() ? Eigen::RowVectorXd(Eigen::RowVectorXd::Unit(size_, i))
                       : Eigen::RowVectorXd(matrix_.row(i));
}

Eigen::MatrixXd Coupling::dense() const {
  return is_identity() ? Eigen::MatrixXd(Eigen::MatrixXd::Identity(size_, size_)) : matrix_;
}

Coupling Coupling::inverse() const { return is_identity() ? *this : Coupling(qerr::inverse(matrix_)); }

Coupling Coupling::magnitudes() const { return is_identity() ? *this : Coupling(matrix_.cwiseAbs()); }

Eigen::MatrixXd Coupling::times(const Eigen::MatrixXd& m) const {
  return is_identity() ? m : Eigen::MatrixXd(matrix_ * m);
}

Eigen::MatrixXd Coupling::after(const Eigen::MatrixXd& m) const {
  return is_identity() ? m : Eigen::MatrixXd(m * matrix_);
}

}  // namespace qerr
