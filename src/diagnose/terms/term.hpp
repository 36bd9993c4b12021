#pragma once

#include <Eigen/Core>
#include <vector>

#include "diagnose/record/evidence.hpp"
#include "qerr/effect/effect.hpp"

namespace qerr {

/// A cause that may add to what an encoder reads: its regressors, and how their coefficients make it an
/// effect.
struct Term {
  Effect effect;            ///< choices and fixed numbers; the free numbers are filled in
  Eigen::ArrayXXd columns;  ///< rows x coefficients; columns * coefficients is what it adds [rad or m]
  /// What it adds beside: of a cause that is not linear, in whose columns its slope stands. Empty: nothing.
  Eigen::ArrayXd fixed = {};
  void (*fill)(Effect&, const Eigen::VectorXd& coefficients) = nullptr;
  /// What it is that has no name; "" for a cause of the catalogue.
  std::string unnamed = {};
  /// A number that the columns depend on other than linearly (an order, a time), and the same term with
  /// another; `reach` is how far the record lets it be off.
  double shape = 0, reach = 0;
  Term (*reshaped)(const Evidence&, const Term&, double shape) = nullptr;

  /// The same term with the slope at other coefficients; none: it is linear.
  Term (*relinearized)(const Evidence&, const Term&, const Eigen::VectorXd& coefficients) = nullptr;

  /// What clock, link and gear before it move its path by, row by row; empty: nothing. And the same term
  /// along a path moved by so much; none: it does not depend on the path, or does so too little.
  Eigen::ArrayXd moved = {};
  Term (*along)(const Evidence&, const Term&, const Eigen::ArrayXd& moved) = nullptr;

  bool named() const { return unnamed.empty(); }

  Eigen::Index size() const { return columns.cols(); }
};

/// What a term adds to the rows that its columns stand for [rad or m].
Eigen::ArrayXd addition(const Term&, const Eigen::VectorXd& coefficients);

/// A term that adds its columns and nothing else: what makes a term's columns anew (for another shape, along
/// another path, at other coefficients) would bring back the ones that these were made from, which may not
/// even be as many.
Term with_columns(Term, Eigen::ArrayXXd columns);

/// Every cause of the catalogue that adds linearly in its coefficients, as far as the evidence can show it.
std::vector<Term> named_terms(const Evidence&);

/// amplitude * sin(order * angle + phase) of either shaft.
Term periodic_term(const Evidence&, const char* type, double order, bool of_encoder);

/// The same at an order that a scan found [periods per rad or m of the joint * 2 pi].
Term free_order_term(const Evidence&, double order);

/// Counts lost or gained at one moment.
Term step_term(const Evidence&, double time);

/// Anything that depends on the position alone, on the time alone: hats between evenly spaced knots.
Term position_table_term(const Evidence&, Eigen::Index knots);
Term time_table_term(const Evidence&, Eigen::Index knots);

/// A vibration of one frequency [Hz].
Term vibration_term(const Evidence&, double frequency);

}  // namespace qerr
