#pragma once

#include <Eigen/Core>
#include <vector>

#include "qerr/diagnose/evidence.hpp"
#include "qerr/effect/effect.hpp"

namespace qerr {

/// A cause that may add to what an encoder reads: its regressors, and how their coefficients make it an
/// effect.
struct Term {
  Effect effect;            ///< choices and fixed numbers; the free numbers are filled in
  Eigen::ArrayXXd columns;  ///< rows x coefficients; columns * coefficients is what it adds [rad or m]
  void (*fill)(Effect&, const Eigen::VectorXd& coefficients) = nullptr;
  bool named = true;  ///< false: something that repeats, wanders or vibrates, and has no name

  Eigen::Index size() const { return columns.cols(); }
};

/// Every cause of the catalogue that adds linearly in its coefficients, as far as the evidence can show it.
std::vector<Term> named_terms(const Evidence&);

/// amplitude * sin(order * angle + phase) of either shaft.
Term periodic_term(const Evidence&, const char* type, double order, bool of_encoder);

/// Counts lost or gained at one moment.
Term step_term(const Evidence&, double time);

}  // namespace qerr
