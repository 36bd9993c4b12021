#include <array>
#include <cmath>
#include <numbers>

#include "core/text.hpp"
#include "report/analysis/ellipsoids.hpp"
#include "report/analysis/page/pictures.hpp"
#include "report/page/plot.hpp"

namespace qerr {

namespace {

/// Origins of the base, of the moved joint frames and of the tip, in the base frame [m].
std::vector<Eigen::Vector3d> skeleton(const Chain& chain, const Eigen::VectorXd& q) {
  std::vector<Eigen::Vector3d> points{Eigen::Vector3d::Zero()};
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
  for (const ChainJoint& joint : chain.joints) {
    const double value = joint.multiplier * q[static_cast<Eigen::Index>(joint.coordinate)] + joint.offset;
    frame = frame * joint.origin;
    points.emplace_back(frame.translation());
    if (joint.prismatic)
      frame.translate(value * joint.axis);
    else
      frame.rotate(Eigen::AngleAxisd(value, joint.axis));
    points.emplace_back(frame.translation());
  }
  points.emplace_back((frame * chain.tip_offset).translation());
  return points;
}

/// The largest of 1, 2, 5 times a power of ten by which the ellipsoid spans at most a sixth of the reach.
double magnification(double reach, double sigma) {
  const double most = reach / 6 / sigma, power = std::pow(10, std::floor(std::log10(most)));
  return power * (most >= 5 * power ? 5 : most >= 2 * power ? 2 : 1);
}

/// The outline of the ellipsoid's projection: C = D diag(s^2) D^T has the outline C^(1/2) (cos t, sin t) of
/// its block of two rows.
page::Series outline(const Eigen::Matrix3d& covariance, const Eigen::Vector3d& tip, std::array<int, 2> rows,
                     double factor) {
  const double a = covariance(rows[0], rows[0]), b = covariance(rows[0], rows[1]),
               c = covariance(rows[1], rows[1]);
  const double first = std::sqrt(a), second = a > 0 ? b / first : 0;  // Cholesky
  const double rest = std::sqrt(std::max(0.0, c - second * second));
  page::Series s{"one sigma, " + significant(factor, 6) + " times larger", {}};
  constexpr int points = 48;
  for (int i = 0; i <= points; ++i) {
    const double t = 2 * std::numbers::pi * i / points;
    s.points.emplace_back(tip[rows[0]] + factor * first * std::cos(t),
                          tip[rows[1]] + factor * (second * std::cos(t) + rest * std::sin(t)));
  }
  return s;
}

}  // namespace

std::string robot_figures(const Analysis& a) {
  const std::vector<TipEllipsoids> all = tip_ellipsoids(a);
  if (all.empty() || all[0].of != "position" || a.workspace.largest_at.size() == 0)
    return "<p>Without x, y and z among the coordinates there is no ellipsoid.</p>";
  const Eigen::VectorXd& q = a.workspace.largest_at;
  const ErrorEllipsoid& e = all[0].at_largest;
  const std::vector<Eigen::Vector3d> points = skeleton(a.spec.model.chain, q);
  double reach = 0;
  for (const Eigen::Vector3d& p : points) reach = std::max(reach, p.norm());
  Eigen::Matrix3d d = e.directions;
  if (a.spec.model.frame == CoordinateFrame::tip) d = forward_kinematics(a.spec.model.chain, q).linear() * d;
  const Eigen::Matrix3d covariance = d * e.semi_axes.cwiseAbs2().asDiagonal() * d.transpose();
  const double factor = e.semi_axes[0] > 0 && reach > 0 ? magnification(reach, e.semi_axes[0]) : 1;
  std::string out = "<p>Semi-axes of one sigma: " + readable(e.semi_axes[0], "m") + ", " +
                    readable(e.semi_axes[1], "m") + ", " + readable(e.semi_axes[2], "m") +
                    ".</p><div class=\"figures\">";
  constexpr std::array<const char*, 3> axes{"x", "y", "z"};
  for (const std::array<int, 2> rows : {std::array{0, 1}, {0, 2}, {1, 2}}) {
    const std::string x = axes[static_cast<std::size_t>(rows[0])],
                      y = axes[static_cast<std::size_t>(rows[1])];
    page::Series robot{"robot", {}, true};
    for (const Eigen::Vector3d& p : points) robot.points.emplace_back(p[rows[0]], p[rows[1]]);
    page::Plot plot{"View " + x + y,
                    "The robot in the base frame, with the ellipsoid of one sigma at its tip.",
                    {x, "m", false, false},
                    {y, "m", false, false},
                    {robot, outline(covariance, points.back(), rows, factor)}};
    plot.equal_scales = true;
    out += figure(plot);
  }
  return out + "</div>";
}

}  // namespace qerr
