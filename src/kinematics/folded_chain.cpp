#include "kinematics/folded_chain.hpp"

#include <cmath>
#include <numbers>

namespace qerr {

namespace {

using Real = long double;
using Matrix = Eigen::Matrix<Real, 3, 3>;
using Vector = Eigen::Matrix<Real, 3, 1>;

/// Angles [rad] and lengths (relative to the chain's) taken as 0: some units of a double's last place.
constexpr Real negligible = 1e-15L;
/// sin(tilt) below which axes count as nearly parallel: the foot of the common normal is up to 1/0.02 times
/// as far away as the axes are apart, and cancellation loses as many digits.
constexpr Real nearly_parallel = 0.02L;

/// A rotation that maps z to the axis.
Matrix rotation_to(const Vector& axis) {
  const Vector z = axis.normalized();
  Eigen::Index least = 0;
  z.cwiseAbs().minCoeff(&least);
  Matrix m;
  m.col(2) = z;
  m.col(0) = (Vector::Unit(least) - z[least] * z).normalized();
  m.col(1) = z.cross(m.col(0));
  return m;
}

Matrix about_z(Real angle) {
  Matrix m = Matrix::Identity();
  m(0, 0) = m(1, 1) = std::cos(angle);
  m(1, 0) = std::sin(angle);
  m(0, 1) = -m(1, 0);
  return m;
}

/// R = Rz(before) Rx(tilt) Rz(after), with tilt in [0, pi].
struct Twist {
  Real before = 0, cosine = 1, sine = 0, after = 0;
};

/// @param aside  a point on the next axis, which determines `before` of parallel axes; 0: they coincide
Twist twist_of(const Matrix& r, const Vector& aside) {
  Twist t;
  t.sine = std::hypot(r(0, 2), r(1, 2));
  t.cosine = r(2, 2);
  if (t.sine <= negligible) {
    t.sine = 0;
    t.cosine = std::copysign(Real{1}, r(2, 2));
    if (aside[0] != 0 || aside[1] != 0) t.before = std::atan2(aside[1], aside[0]);
  } else {
    if (std::abs(t.cosine) <= negligible) t.cosine = 0, t.sine = 1;
    t.before = std::atan2(r(0, 2), -r(1, 2));
  }
  const Matrix residual = about_z(-t.before) * r;
  t.after = std::atan2(-residual(0, 1), residual(0, 0));
  return t;
}

/// Folds joint after joint. The fixed transform between two joints is complete when the second one is added.
class Folder {
 public:
  explicit Folder(const Chain& chain) {
    for (const ChainJoint& joint : chain.joints) extent_ += joint.origin.translation().cast<Real>().norm();
    extent_ += chain.tip_offset.translation().cast<Real>().norm();
  }

  void add(const ChainJoint& joint) {
    const Matrix to_axis = rotation_to(joint.axis.cast<Real>());
    const Matrix r = pending_ * joint.origin.linear().cast<Real>() * to_axis;
    const Vector t = pending_ * joint.origin.translation().cast<Real>();
    if (folded_.joints.empty())
      begin(r, t);
    else
      step(r, t);
    FoldedJoint& f = folded_.joints.back();
    f.prismatic = joint.prismatic;
    f.coordinate = joint.coordinate;
    f.sign = static_cast<double>(sign_z_);
    const auto sign = static_cast<double>(joint.prismatic ? sign_z_ : sign_y_);
    f.multiplier = sign * joint.multiplier;
    f.offset = sign * joint.offset;
    pending_ = to_axis.transpose();
  }

  FoldedChain finish(const Chain& chain, bool orientation) {
    Vector t = pending_ * chain.tip_offset.translation().cast<Real>();
    const Real rotation = !folded_.joints.back().prismatic && std::hypot(t[0], t[1]) > small()
                              ? std::atan2(t[1], t[0])
                              : Real{0};
    rotation_ += rotation;
    end_rotation();
    t = about_z(-rotation) * t;
    translate(t[2]);
    folded_.tip_x = plain(t[0]);
    folded_.tip_y = plain(sign_y_ * t[1]);
    Matrix axes = about_z(-rotation) * pending_ * chain.tip_offset.linear().cast<Real>();
    axes.row(1) *= sign_y_;
    axes.row(2) *= sign_z_;
    folded_.tip_axes = axes.cast<double>();
    link_axes(about_z(-rotation));
    FoldedJoint& last = folded_.joints.back();
    if (!orientation && folded_.tip_x == 0 && folded_.tip_y == 0) last.rotates = false;
    prepare_joints();
    return std::move(folded_);
  }

 private:
  Real small() const { return negligible * extent_; }
  double plain(Real length) const { return std::abs(length) <= small() ? 0 : static_cast<double>(length); }

  /// The first joint.
  void begin(const Matrix& r, const Vector& t) {
    folded_.joints.emplace_back();
    folded_.first_point = t.cast<double>();
    if (std::hypot(r(0, 2), r(1, 2)) > negligible) {
      folded_.first_axes = r.cast<double>();
      return;
    }
    // Rotate about the axis until X is the base's x; reverse an axis that points down.
    rotation_ = std::atan2(r(1, 0), r(0, 0));
    if (r(2, 2) < 0) {
      sign_y_ = sign_z_ = -1;
      rotation_ = -rotation_;
    }
  }

  /// Transform from the last joint's axis to the next one's.
  void step(const Matrix& r, const Vector& t) {
    const Twist twist = twist_of(r, std::hypot(t[0], t[1]) > small() ? t : Vector::Zero());
    rotation_ += twist.before;
    end_rotation();
    Vector step = about_z(-twist.before) * t;
    link_axes(about_z(-twist.before));
    Real along = 0;  // translation along the next axis
    if (twist.sine > nearly_parallel) {
      along = -step[1] / twist.sine;
      step[1] = 0;
      step[2] -= along * twist.cosine;
    }
    translate(step[2]);
    FoldedJoint& f = folded_.joints.emplace_back();
    f.a = plain(step[0]);
    f.b = plain(sign_y_ * step[1]);
    tilt(twist, f);
    f.d = plain(sign_z_ * along);
    rotation_ = twist.after;
  }

  void tilt(const Twist& twist, FoldedJoint& f) {
    Real cosine = twist.cosine, sine = twist.sine;
    if (sine > std::abs(cosine)) {
      f.right_angle = true;
      const Real y = sign_y_;
      sign_y_ = sign_z_;
      sign_z_ = -y;
      cosine = twist.sine;
      sine = -twist.cosine;
    } else if (cosine < 0) {
      sign_y_ = -sign_y_;
      sign_z_ = -sign_z_;
      cosine = -cosine;
      sine = -sine;
    }
    sine *= sign_y_ * sign_z_;
    f.tilts = sine != 0;
    f.sine = static_cast<double>(sine);
    f.half_tangent = static_cast<double>(sine / (1 + cosine));
  }

  /// Translates the last joint's point along its axis.
  void translate(Real length) {
    FoldedJoint& f = folded_.joints.back();
    if (folded_.joints.size() == 1)
      folded_.first_point += (folded_.first_axes.col(2).cast<Real>() * (sign_z_ * length)).cast<double>();
    else
      f.d = plain(f.d + sign_z_ * length);
  }

  /// Stores the constant part of the last joint's rotation, once it is complete.
  void end_rotation() {
    FoldedJoint& f = folded_.joints.back();
    const Real rotation = std::remainder(sign_y_ * rotation_, 2 * std::acos(Real{-1}));
    const Real constant = std::abs(rotation) <= negligible ? 0 : rotation;
    if (f.prismatic) {
      f.rotates = constant != 0;
      f.rotation_cosine = static_cast<double>(std::cos(constant));
      f.rotation_sine = static_cast<double>(std::sin(constant));
    } else {
      f.offset = static_cast<double>(f.offset + constant);
    }
    rotation_ = 0;
  }

  /// Rotation from the frame behind the last joint of the chain to the folded one.
  void link_axes(const Matrix& rotated_back) {
    Matrix m = rotated_back * pending_;
    m.row(1) *= sign_y_;
    m.row(2) *= sign_z_;
    folded_.link_axes.push_back(m.cast<double>());
  }

  /// Derived members of the joints. Intersecting axes share one point.
  void prepare_joints() {
    bool shared = false;  // the frame's point is the one stored last
    for (FoldedJoint& f : folded_.joints) {
      f.has_a = f.a != 0;
      f.has_b = f.b != 0;
      f.has_d = f.d != 0;
      f.own_point = !shared || f.has_a || f.has_b;
      shared = !f.prismatic && (f.own_point || !f.has_d);
      set_motion(f, f.multiplier, f.offset);
    }
  }

  FoldedChain folded_;
  Matrix pending_ = Matrix::Identity();  // from the frame of the last axis to the chain's frame
  Real rotation_ = 0;                    // constant rotation about the last axis so far
  Real sign_y_ = 1, sign_z_ = 1;         // of the stored axes
  Real extent_ = 0;
};

}  // namespace

FoldedPath path_of(const FoldedChain& c) {
  return {c.joints.data(), c.joints.size(), c.first_axes.data(), c.first_point.data(), c.axes_length,
          c.tip_x,         c.tip_y,         c.tip_axes.data()};
}

void set_motion(FoldedJoint& joint, double multiplier, double offset) {
  constexpr Real quarters = 2 / std::numbers::pi_v<Real>;
  joint.multiplier = multiplier;
  joint.offset = offset;
  joint.quarter_multiplier = static_cast<double>(multiplier * quarters);
  joint.quarter_offset = static_cast<double>(offset * quarters);
}

void scale_axes(FoldedChain& chain, double length) {
  const double by = length / chain.axes_length;
  chain.axes_length = length;
  chain.first_axes *= by;
  chain.tip_x /= by;
  chain.tip_y /= by;
  for (FoldedJoint& f : chain.joints) {
    for (double* along : {&f.a, &f.b, &f.d}) *along /= by;
    if (!f.prismatic) continue;
    f.multiplier /= by;
    f.offset /= by;
  }
}

FoldedChain fold(const Chain& chain, bool orientation) {
  Folder folder(chain);
  for (const ChainJoint& joint : chain.joints) folder.add(joint);
  return folder.finish(chain, orientation);
}

}  // namespace qerr
