#pragma once

#include <Eigen/Geometry>
#include <limits>
#include <vector>

#include "qerr/bound/operational_error.hpp"
#include "qerr/kinematics/robot_model.hpp"

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

/// Upper bound of a figure over a box of joint coordinates, from one configuration, its center.
///
/// Every term g(q) is a component of a derivative of a position (or, in the frame of the tip, of a twist), so
/// that its partial derivatives are, too: with axes a <= b <= c of the chain,
/// d2 p/(da db) = z_a x J_b and d3 p/(da db dc) = z_a x (z_b x J_c), and |J_c| over the box is at most |J_c|
/// at the center plus sum_{l > c} r_l |J_l| (r: half widths of the box). The bound has two steps:
/// 1. lower <= g <= upper of each term, from its value and gradient at the center and the bound of its second
///    derivatives.
/// 2. |g| and g^2 are convex: they lie below the chord over [lower, upper]. The sum of the chords is one
///    combination L of the columns, with L(center) + max over the box of its gradient and Hessian at the
///    center, joint by joint, + the off-diagonal part of the Hessian + the bound of its third derivatives.
/// A term of constant sign has |g| for its chord, so that near a maximum the bound is of third order.
///
/// Rounding: a pose is a product of n transforms, each with an error of less than 16 epsilon, and epsilon per
/// radian of its angle (relative to the length of the chain); columns, sums over axes and terms, and the
/// bound itself add less than 48 epsilon per axis and term. This times the figure's size with all axes at the
/// full length of the chain is added, and times (1 + the summed half widths)^2, as gradient and Hessian are
/// multiplied by these.
class BoxBound {
 public:
  BoxBound(const ErrorTerms&, const std::vector<Limits>& ranges);
  BoxBound(const BoxBound&) = delete;
  BoxBound& operator=(const BoxBound&) = delete;

  struct Result {
    double upper = 0;        ///< of the figure in the box
    double at_center = 0;    ///< the figure there
    std::size_t widest = 0;  ///< joint whose range contributes most to the bound
  };
  /// @param half  half widths of the box [rad or m], 0 of a joint without influence
  Result operator()(const Eigen::VectorXd& center, const Eigen::VectorXd& half);

  /// Whether the figure depends on the joint: it does not on those that only turn the base about the figure's
  /// direction, or the whole vector of a length.
  bool matters(std::size_t joint) const { return matters_[joint]; }

  /// Allowance for rounding in the bound of a small box.
  double rounding() const { return rounding_; }

 private:
  using Columns = Eigen::Matrix3Xd;
  struct Part {  // of a figure: size |g| or (size g)^2
    Eigen::VectorXd weights;
    double size;
  };

  void set_parts();
  void set_rounding(const std::vector<Limits>& ranges);
  bool turns_whole(const TermColumns&, std::size_t axis) const;
  void set_influence(const std::vector<Limits>& ranges);
  void set_reach(const Eigen::VectorXd& half);
  void set_first(const Eigen::VectorXd& half);
  Eigen::Vector3d first(std::size_t motion, std::size_t column) const;
  Eigen::Vector3d second(std::size_t i, std::size_t j, std::size_t column) const;
  double remainder(int order, const Eigen::VectorXd& magnitudes) const;
  double remainder_in_base(int order, const Eigen::VectorXd& magnitudes) const;
  double remainder_in_tip(int order, const Eigen::VectorXd& magnitudes) const;
  double chords(const Eigen::VectorXd& half, Columns& slopes, Eigen::VectorXd& blame, double& plain) const;
  double combined(const Eigen::VectorXd& half, const Columns& slopes, Eigen::VectorXd& blame) const;

  const ErrorTerms& terms_;
  std::size_t count_, joints_;
  std::vector<std::size_t> movers_;  // axes that joints move
  std::vector<Part> parts_;
  std::vector<bool> matters_;
  Eigen::VectorXd length_;  // [axis]: bound of its column over all ranges
  double rounding_ = 0;     // allowance for a small box
  TermColumns at_;
  Eigen::VectorXd radius_, reach_;   // [axis]: half width of its motion; bound of its column over the box
  std::vector<Columns> derivative_;  // [joint]: of the columns, 3 x axes
};

/// Result of branch and bound.
struct SearchedMaximum {
  double upper = 0;    ///< of the figure over the box of the ranges, rounding included
  Eigen::VectorXd at;  ///< center of a box with the largest value among all centers
};

/// Upper bound of a figure over the box of the joint ranges: the box with the largest bound (BoxBound)
/// is halved along the joint that contributes most to it, until no bound exceeds `known_lower` (1 + gap), or
/// `boxes` boxes were bounded.
/// @param known_lower  a value that the figure has in the box
SearchedMaximum branch_and_bound(const ErrorTerms&, const std::vector<Limits>& ranges, double known_lower,
                                 double gap, std::size_t boxes);

/// Number of boxes for a gap: 131072 at 1 %, in proportion to 1/gap, at most 2^21. About 5 us each.
std::size_t boxes_of_gap(double gap);

/// Allowance for the rounding of the figure itself, as `operational_error` and `workspace` compute it
/// (BoxBound).
double rounding_allowance(const ErrorTerms&, const std::vector<Limits>& ranges);

/// Joints on which the figure depends.
std::size_t influential_joints(const ErrorTerms&, const std::vector<Limits>& ranges);

}  // namespace qerr
