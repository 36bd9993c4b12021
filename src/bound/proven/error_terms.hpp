#pragma once

#include <Eigen/Geometry>
#include <limits>
#include <vector>

#include "qerr/bound/operational_error.hpp"

namespace qerr {

inline constexpr double machine_epsilon = std::numeric_limits<double>::epsilon();

/// A joint of the chain, or a fixed direction in it, and its column: [m/rad or 1] of a position.
struct TermAxis {
  Eigen::Isometry3d before = Eigen::Isometry3d::Identity();  ///< from the frame behind the previous axis
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  bool turns = false;              ///< column z x (p - o); else z
  bool of_joint = false;           ///< of the chain, not a fixed direction
  std::ptrdiff_t coordinate = -1;  ///< index of the independent joint that moves it; -1: fixed
  double multiplier = 1, offset = 0;
};

/// An independent error: its derivative with respect to each axis, and its size.
struct ErrorTerm {
  Eigen::VectorXd weights;  ///< [axis]
  double half_width = 0, mean = 0, sigma = 0;
};

/// Columns of the axes at a configuration, 3 x axes, in the frame of the figure; `turning` has the axes of
/// those that turn and 0 elsewhere.
struct TermColumns {
  Eigen::Matrix3Xd columns, turning;
};

/// One figure of a model as a function of its independent joints, without what does not depend on it:
///
/// with v_g = sum_k weights_gk column_k the worst case of a coordinate along u is sum_g half_width_g |u.v_g|
/// + |sum_g mean_g u.v_g| + added, its variance sum_g sigma_g^2 (u.v_g)^2 + added^2; those of a length are
/// the largest length over the corners, and the sum over x y z.
///
/// A rotation has the columns z_k: before each joint that turns stands a fixed direction, its axis, which
/// has the weights. Displaced origins are fixed directions, too.
/// @pre the coordinate is no Euler angle
class ErrorTerms {
 public:
  ErrorTerms(const OperationalModel&, std::size_t coordinate, bool sigma);

  /// At independent coordinates q [rad or m].
  TermColumns columns(const Eigen::VectorXd& q) const;
  /// v_g as columns, 3 x terms.
  Eigen::Matrix3Xd vectors(const TermColumns&) const;
  /// The figure, from v_g.
  double value(const Eigen::Matrix3Xd& vectors) const;
  double value(const Eigen::VectorXd& q) const { return value(vectors(columns(q))); }

  const std::vector<TermAxis>& axes() const { return axes_; }
  const std::vector<ErrorTerm>& terms() const { return terms_; }
  Eigen::Vector3d tip() const { return tip_.translation(); }  ///< in the frame of the last axis
  bool sigma() const { return sigma_; }
  bool in_tip_frame() const { return in_tip_frame_; }
  bool length() const { return length_; }
  Eigen::Index row() const { return row_; }  ///< of the coordinate in x y z or rx ry rz; 0 for a length
  double added() const { return added_; }    ///< of a worst case, or root of the added variance
  bool turned_base() const { return turned_base_; }  ///< of along_any_direction

  /// Axes that the independent joint moves.
  std::vector<std::size_t> moved_by(std::size_t joint) const;

  /// Largest |angle| or |displacement| of an axis over the ranges [rad or m].
  double largest_motion(const TermAxis&, const std::vector<Limits>& ranges) const;
  /// Bounds of the columns over the ranges, without their directions: of an axis that turns the length of the
  /// chain beyond it, else 1.
  Eigen::VectorXd longest_columns(const std::vector<Limits>& ranges) const;

  /// The worst case of a length as that of x on a base that turns: the largest length over the corners is the
  /// largest worst case along any direction. Two joints without encoders, with the coordinates `joints` and
  /// `joints` + 1, turn x over half of the sphere as they go from -pi/2 to pi/2.
  ErrorTerms along_any_direction(std::size_t joints) const;

 private:
  void add_axes(const OperationalModel&, bool rotation);
  void add_turning_axis(TermAxis);
  void add_terms(const OperationalModel&, bool rotation);
  void add_term(const Eigen::VectorXd& of_joints, double half_width, double mean, double sigma);
  void add_along_motion(const OperationalModel&, Coordinate);

  std::vector<TermAxis> axes_;
  std::vector<ErrorTerm> terms_;
  std::vector<std::size_t> column_of_joint_;  // of the chain
  std::vector<double> sign_of_joint_;         // 1 or -1
  std::vector<std::size_t> axis_of_error_;    // of displaced origins
  Eigen::Isometry3d tip_ = Eigen::Isometry3d::Identity();
  bool sigma_, in_tip_frame_ = false, length_ = false, turned_base_ = false;
  Eigen::Index row_ = 0;
  double added_ = 0;
};

}  // namespace qerr
