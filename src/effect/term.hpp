#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "effect/record_signals.hpp"
#include "qerr/effect/effect.hpp"
#include "qerr/effect/residual_shape.hpp"

namespace qerr {

/// A candidate cause of an encoder's error in a regression: its regressors, and the map from their
/// coefficients to the parameters of an effect.
struct Term {
  Effect effect;            ///< choices and fixed numbers; `fill` adds the free ones
  Eigen::ArrayXXd columns;  ///< rows x coefficients; columns * coefficients is its addition [rad or m]
  /// Constant part of the linearization of an effect that is not linear in its parameters, in addition to
  /// columns * coefficients. Empty: zero.
  Eigen::ArrayXd fixed = {};
  void (*fill)(Effect&, const Eigen::VectorXd& coefficients) = nullptr;
  /// Description of an uncatalogued term; empty if catalogued.
  std::string unnamed = {};
  Shape pattern = Shape::unknown;  ///< of an uncatalogued term
  /// What to inspect, of an uncatalogued term; empty: that of its pattern. A literal.
  std::string_view next = {};

  bool constant = false;  ///< the same at every row
  bool step = false;      ///< zero before the time `effect.number("time")`
  bool whole = false;     ///< its coefficients are integers, in counts
  bool positive = false;  ///< a negative coefficient has no physical meaning
  bool harmonic = false;  ///< a sine of a shaft's angle

  /// A parameter on which the columns depend non-linearly (an order, a time constant), the half-width of its
  /// search interval, and the same term at another value; null for a term without such a parameter.
  double shape = 0, half_width = 0;
  Term (*reshaped)(const RecordSignals&, const Term&, double shape) = nullptr;

  /// The term linearized at other coefficients; null: it is linear.
  Term (*relinearized)(const RecordSignals&, const Term&, const Eigen::VectorXd& coefficients) = nullptr;

  /// Displacement of its path by clock, link and gear, row by row (empty: zero), and the same term along a
  /// path with another displacement; null if its dependence on the path is negligible.
  Eigen::ArrayXd moved = {};
  Term (*along)(const RecordSignals&, const Term&, const Eigen::ArrayXd& moved) = nullptr;

  /// Column of a hysteresis of this size, from the readings or, with `of_reference`, from the reference's
  /// path: per unit of the size. Null without hysteresis.
  Eigen::ArrayXd (*hysteresis)(const Eigen::ArrayXd& driving, double size) = nullptr;
  bool of_reference = false;

  bool named() const { return unnamed.empty(); }

  Eigen::Index size() const { return columns.cols(); }
};

/// Contribution of a term to every row: columns * coefficients + fixed [rad or m].
Eigen::ArrayXd addition(const Term&, const Eigen::VectorXd& coefficients);

/// A term that consists of its columns alone. Functions that recompute columns (for another shape, path or
/// linearization) are removed: they would restore the original ones, even in another number.
Term with_columns(Term, Eigen::ArrayXXd columns);

/// A term that is linear in its one column.
Term linear_term(const RecordSignals&, std::string_view effect, Eigen::ArrayXd column,
                 void (*fill)(Effect&, const Eigen::VectorXd&));

/// All catalogued terms that are linear in their coefficients, or linearized, and that the signals can show.
std::vector<Term> named_terms(const RecordSignals&);

/// The catalogued step effect at a time [s].
Term step_term(const RecordSignals&, double time);

/// amplitude * sin(order * angle + phase) of the encoder's or the joint's shaft, by the effect of this order.
Term periodic_term(const RecordSignals&, double order, bool of_encoder);

/// A sine at an order of the joint that a scan found [periods per rad or m of the joint * 2 pi];
/// uncatalogued.
Term free_order_term(const RecordSignals&, double order);

/// Of a shorter part of a sine a parabola leaves less than 1.7 % (rms, worst phase): no order is told apart
/// from another [periods].
inline constexpr double least_periods = 0.25;

/// Periods of a periodic effect that a record covers.
double periods_covered(const Effect&, const RecordSignals&);

}  // namespace qerr
