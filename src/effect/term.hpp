#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "qerr/effect/effect.hpp"
#include "qerr/encoder/encoder.hpp"

namespace qerr {

/// Signals of one encoder's record from which regressors of effects are computed, row by row, in the
/// encoder's coordinate (at the joint's side of its gear).
struct RecordSignals {
  std::string joint;  ///< whose encoder it is
  bool prismatic = false;
  Encoder encoder;
  bool ordered = true;          ///< the rows follow each other in time
  bool counted = true;          ///< readings are whole counts
  bool loaded = true;           ///< the joint's own weight can load it
  Eigen::ArrayXd time;          ///< from the first row [s]; the row's number if the record has no time
  Eigen::ArrayXd path;          ///< the reference without its noise [rad or m]
  Eigen::ArrayXd velocity;      ///< of the path [rad/s or m/s]
  Eigen::ArrayXd acceleration;  ///< of the joint's own path [rad/s^2 or m/s^2]; empty where it is not known
  Eigen::ArrayXd direction;     ///< direction of the joint's last motion: -1, +1, or 0 before the first
  Eigen::ArrayXd measured;      ///< readings as recorded [rad or m]; empty in a plan
  /// The joint's own position and velocity where its encoder measures other joints too (coupling); else
  /// empty.
  Eigen::ArrayXd joint_path, joint_velocity;
  Eigen::ArrayXd effort;       ///< [N m or N]; empty where it is not known
  bool driven = true;          ///< the effort is a drive's, which needs a part of it for itself
  Eigen::ArrayXd temperature;  ///< rise since the start [K]; empty where it is not known

  Eigen::Index rows() const { return path.size(); }
  double step() const { return encoder.resolution; }
  /// Of the joint: what clock, link and gear act on.
  const Eigen::ArrayXd& joint_angle() const { return joint_path.size() > 0 ? joint_path : path; }
  const Eigen::ArrayXd& joint_rate() const { return joint_velocity.size() > 0 ? joint_velocity : velocity; }
  bool coupled() const { return joint_path.size() > 0; }
  double range() const { return path.maxCoeff() - path.minCoeff(); }  ///< of the path [rad or m]
  /// Whether the encoder moves by less than 8 counts (convention): effects of position and speed are then not
  /// identifiable.
  bool is_stationary() const { return range() < 8 * step(); }
  /// Whether the readings tell where the drive of a play of this width is: it has three counts or more, and
  /// they turn round hardly more often than the joint. Readings that noise turns round do not.
  bool readings_drive(double gap) const;
  /// What the readings say of the drive of a play, in the measure of the joint: without their ratio to the
  /// path, or a play of many rows would not be crossed where the joint has hardly moved. With a ratio that
  /// the play itself may make: half of it, along with the path.
  Eigen::ArrayXd drive(double gap) const;
};

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

  bool constant = false;      ///< the same at every row
  bool step = false;          ///< zero before the time `effect.number("time")`
  bool whole = false;         ///< its coefficients are integers, in counts
  Eigen::Index positive = 0;  ///< leading coefficients of which a negative one has no physical meaning
  bool harmonic = false;      ///< a sine of a shaft's angle

  /// A parameter on which the columns depend non-linearly (an order, a time constant), the half-width of its
  /// search interval, and the same term at another value; null for a term without such a parameter.
  double shape = 0, half_width = 0;
  Term (*reshaped)(const RecordSignals&, const Term&, double shape) = nullptr;
  /// The values of that parameter at which a record may have it; null: those of a time constant.
  std::vector<double> (*shapes)(const RecordSignals&) = nullptr;

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
