#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "core/random.hpp"
#include "qerr/encoder/transmission.hpp"
#include "qerr/kinematics/chain.hpp"

namespace qerr::testing {

/// Random numbers that depend on the seed only, and are equal on every machine.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : seed_(seed) {}

  double between(double lower, double upper) {
    return lower + (upper - lower) * unit_interval(random_bits(seed_, drawn_++, 77));
  }
  bool chance(double probability) { return between(0, 1) < probability; }
  std::size_t below(std::size_t count) {
    return static_cast<std::size_t>(between(0, static_cast<double>(count)));
  }
  Eigen::Vector3d direction() {
    for (;;) {
      Eigen::Vector3d v;
      for (const int i : {2, 1, 0}) v[i] = between(-1, 1);
      if (v.norm() > 0.1 && v.norm() < 1) return v.normalized();
    }
  }
  Eigen::Isometry3d frame(double reach) {
    Eigen::Isometry3d t = Eigen::Isometry3d::Identity();
    const double distance = between(0, reach);  // a statement each: the order of arguments is the compiler's
    t.translate(distance * direction());
    const Eigen::Vector3d axis = direction();
    t.rotate(Eigen::AngleAxisd(between(-std::numbers::pi, std::numbers::pi), axis));
    return t;
  }
  /// A random coordinate axis with a random sign.
  Eigen::Vector3d axis() {
    const double sign = chance(0.5) ? 1 : -1;
    return sign * Eigen::Vector3d::Unit(static_cast<Eigen::Index>(below(3)));
  }
  /// A rotation by right angles, exactly, and a translation along a coordinate axis or none.
  Eigen::Isometry3d square_frame(double reach) {
    Eigen::Isometry3d t = Eigen::Isometry3d::Identity();
    if (chance(0.6)) {
      const double distance = between(0, reach);
      t.translate(distance * axis());
    }
    Eigen::Matrix3d m;
    m.col(0) = axis();
    do m.col(1) = axis();
    while (m.col(1).dot(m.col(0)) != 0);
    m.col(2) = m.col(0).cross(m.col(1));
    t.linear() = m;
    return t;
  }
  Eigen::VectorXd vector(Eigen::Index size, double lower, double upper) {
    Eigen::VectorXd v(size);
    for (double& entry : v) entry = between(lower, upper);
    return v;
  }

 private:
  std::uint64_t seed_, drawn_ = 0;
};

/// Parameters of a random robot.
struct ChainMix {
  std::size_t joints = 6;  ///< moving joints from base to tip
  double prismatic = 0.25, mimic = 0.2, fixed = 0.3;
  double reach = 0.5;  ///< largest distance between two joints [m]
  double square =
      0;  ///< probability of frames at right angles with joints about coordinate axes, as in most arms
};

/// A robot with one leaf "tip": skew axes, fixed joints in between, mimics of joints before and after, mimics
/// of mimics.
inline RobotModel random_robot(Dice& dice, const ChainMix& mix) {
  RobotModel robot{"random", "random.urdf", {"base"}, {}, {}};
  const auto extend = [&](std::string name, JointType type) -> Joint& {
    const bool square = mix.square > 0 && dice.chance(mix.square);
    const std::string child = "link_" + std::to_string(robot.links.size());
    robot.joints.push_back({std::move(name),
                            type,
                            robot.links.back(),
                            child,
                            square ? dice.square_frame(mix.reach) : dice.frame(mix.reach),
                            square ? dice.axis() : dice.direction(),
                            {},
                            {},
                            {}});
    robot.links.push_back(child);
    return robot.joints.back();
  };
  const std::size_t free =
      dice.below(mix.joints);  // never a mimic, so that at least one joint is independent
  const auto name = [](std::size_t k) { return "joint_" + std::to_string(k); };
  for (std::size_t k = 0; k < mix.joints; ++k) {
    if (dice.chance(mix.fixed)) extend("fixed_" + std::to_string(k), JointType::fixed);
    const bool slides = dice.chance(mix.prismatic);
    Joint& joint = extend(name(k), slides ? JointType::prismatic : JointType::revolute);
    // Joints before `free` mimic later ones, joints after it earlier ones: no cycle.
    if (k == free || !dice.chance(mix.mimic)) continue;
    const std::size_t target = k < free ? k + 1 + dice.below(free - k) : free + dice.below(k - free);
    const double sign = dice.chance(0.5) ? 1 : -1;
    joint.mimic = Mimic{name(target), sign * dice.between(0.3, 1.5), dice.between(-1, 1)};
  }
  robot.joints.push_back(
      {"tip_fixed",
       JointType::fixed,
       robot.links.back(),
       "tip",
       mix.square > 0 && dice.chance(mix.square) ? dice.square_frame(mix.reach) : dice.frame(mix.reach),
       Eigen::Vector3d::UnitX(),
       {},
       {},
       {}});
  robot.links.push_back("tip");
  return robot;
}

/// Encoders with log-uniform intervals, some rounding down; a diagonally dominant
/// coupling or I.
inline Transmission random_transmission(Dice& dice, const Chain& chain, double finest, double coarsest,
                                        bool coupled) {
  const auto n = static_cast<Eigen::Index>(chain.independent.size());
  Transmission t{{}, {}};
  Eigen::MatrixXd coupling = Eigen::MatrixXd::Identity(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double resolution = finest * std::pow(coarsest / finest, dice.between(0, 1));
    t.encoders.push_back({resolution, dice.chance(0.25) ? Rounding::down : Rounding::nearest, true});
  }
  if (coupled)
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j)
        if (i != j && dice.chance(0.4)) coupling(i, j) = dice.between(-0.8, 0.8) / static_cast<double>(n);
  t.coupling = coupling;
  return t;
}

inline std::vector<std::string> joint_names(const Chain& chain) {
  std::vector<std::string> names;
  for (const IndependentJoint& joint : chain.independent) names.push_back(joint.name);
  return names;
}

/// Of the independent joints [rad or m].
inline Eigen::VectorXd random_configuration(Dice& dice, const Chain& chain) {
  Eigen::VectorXd q(static_cast<Eigen::Index>(chain.independent.size()));
  for (Eigen::Index i = 0; i < q.size(); ++i)
    q[i] = chain.independent[static_cast<std::size_t>(i)].prismatic() ? dice.between(-1, 1)
                                                                      : dice.between(-3.2, 3.2);
  return q;
}

/// f'(0) by five points; error h^4 f'''''/30 and 1e-16/h.
template <class F>
auto derivative_at_zero(const F& f) {
  const double h = 3e-4;
  return ((8 * (f(h) - f(-h)) - (f(2 * h) - f(-2 * h))) / (12 * h)).eval();
}

}  // namespace qerr::testing
