#include "kinematics/inverse_dynamics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <kdl/chainidsolver_recursive_newton_euler.hpp>
#include <numbers>

#include "qerr/input/first_spec.hpp"
#include "simulate/sensing.hpp"
#include "support/random_chain.hpp"

/// The simulated robot: its loads and its geometric errors.
namespace qerr {
namespace {

using testing::ChainMix;
using testing::Dice;

KDL::Vector vector(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

KDL::Rotation rotation(const Eigen::Matrix3d& r) {
  return {r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1), r(1, 2), r(2, 0), r(2, 1), r(2, 2)};
}

Inertia random_load(Dice& dice) {
  Inertia load;
  load.mass = dice.between(0.1, 5);
  load.center = dice.between(0, 0.3) * dice.direction();
  // A set of point masses, so that the inertia is physically possible.
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d r = dice.between(0, 0.2) * dice.direction();
    load.about_center +=
        0.25 * load.mass * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
  }
  return load;
}

/// Serial and without mimics, one segment of KDL per link.
TEST(InverseDynamics, AgreesWithKdlOnRandomRobots) {
  Dice dice(21);
  for (int trial = 0; trial < 200; ++trial) {
    ChainMix mix{1 + dice.below(7), 0.3, 0.0};
    RobotModel robot = random_robot(dice, mix);
    for (std::size_t i = 0; i < robot.links.size(); ++i) robot.inertias.push_back(random_load(dice));
    const Chain chain = make_chain(robot, "", "");
    KDL::Chain reference;
    for (std::size_t i = 0; i < robot.joints.size(); ++i) {
      const Joint& j = robot.joints[i];
      const Inertia& load = robot.inertias[i + 1];  // of its child
      const KDL::Frame origin(rotation(j.origin.linear()), vector(j.origin.translation()));
      const Eigen::Matrix3d& m = load.about_center;
      const KDL::RigidBodyInertia body(
          load.mass, vector(load.center),
          KDL::RotationalInertia(m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(0, 2), m(1, 2)));
      const KDL::Joint joint =
          j.type == JointType::fixed
              ? KDL::Joint(KDL::Joint::Fixed)
              : KDL::Joint(j.name, origin.p, origin.M * vector(j.axis),
                           j.type == JointType::prismatic ? KDL::Joint::TransAxis : KDL::Joint::RotAxis);
      reference.addSegment(KDL::Segment(joint, origin, body));
    }
    const auto n = static_cast<Eigen::Index>(mix.joints);
    const Eigen::VectorXd q = dice.vector(n, -3, 3), v = dice.vector(n, -2, 2), a = dice.vector(n, -5, 5);
    KDL::JntArray kq(static_cast<unsigned>(n)), kv = kq, ka = kq, effort = kq;
    kq.data = q;
    kv.data = v;
    ka.data = a;
    KDL::ChainIdSolver_RNE solver(reference, KDL::Vector(0, 0, -standard_gravity));
    ASSERT_EQ(solver.CartToJnt(kq, kv, ka, KDL::Wrenches(reference.getNrOfSegments()), effort), 0);
    EXPECT_LE((inverse_dynamics(chain, q, v, a) - effort.data).norm(), 1e-11 * (1 + effort.data.norm()));
  }
}

/// A mass on a massless, compliant arm about a horizontal axis: m g l cos q, by hand.
OperationalModel pendulum() {
  OperationalModel m;
  ChainJoint joint;
  joint.name = "elbow";
  joint.axis = -Eigen::Vector3d::UnitY();
  joint.load.mass = 3;
  joint.load.center = {0.4, 0, 0};
  m.chain.joints = {joint};
  m.chain.tip_offset.translation() << 0.5, 0, 0;
  m.chain.independent = {{"elbow", JointType::revolute, {}, true}};
  m.transmission = {{{1e-6}}, Eigen::MatrixXd::Identity(1, 1)};
  m.coordinates = {Coordinate::x, Coordinate::z};
  return m;
}

TEST(Sensing, ComplianceFollowsGravityAndInertia) {
  const double c = 1e-4, a = 0.9, w = 2 * std::numbers::pi * 1.7;
  const Motion motion{1000, 1, {}, {{0.4, 0, {{a, 1.7, 0.3}}, {}}}, {}};
  Sensing sensing(pendulum(), motion, {{"compliance", "elbow", {{"compliance", c}}, {}}},
                  {Eigen::VectorXd::Zero(1)});
  for (std::uint64_t k = 0; k < 1000; ++k) {
    const double t = static_cast<double>(k) / 1000, q = 0.4 + a * std::sin(w * t + 0.3);
    const double acceleration = -a * w * w * std::sin(w * t + 0.3);
    const double torque = 3 * 9.80665 * 0.4 * std::cos(q) + 3 * 0.16 * acceleration;
    const Reading& r = sensing.read(k);
    EXPECT_NEAR(r.effort[0], torque, 1e-9);
    EXPECT_NEAR(r.measured[0], q + c * torque, 0.51e-6);
  }
}

std::string arm(const std::string& elbow_origin) {
  return "<robot name='arm'><link name='base'/><link name='a'/><link name='b'/><link name='c'/><link "
         "name='tip'/>"
         "<joint name='shoulder' type='continuous'><parent link='base'/><child link='a'/>"
         "<origin xyz='0 0 0.3' rpy='0.2 0.1 0.4'/><axis xyz='0 1 0'/></joint>"
         "<joint name='bracket' type='fixed'><parent link='a'/><child link='b'/>"
         "<origin xyz='0.1 0 0' rpy='0 0.7 1.1'/></joint>"
         "<joint name='elbow' type='continuous'><parent link='b'/><child link='c'/><origin xyz='" +
         elbow_origin +
         "' rpy='0.5 0 -0.3'/><axis xyz='0 0 1'/></joint>"
         "<joint name='flange' type='fixed'><parent link='c'/><child link='tip'/><origin xyz='0 0.2 "
         "0.1'/></joint>"
         "</robot>";
}

TEST(Sensing, GeometryMovesTheOriginOfTheUrdf) {
  const Chain nominal = make_chain(parse_urdf(arm("0.4 0.05 0"), "arm.urdf"), "", "");
  const Chain longer = make_chain(parse_urdf(arm("0.4 0.053 0"), "arm.urdf"), "", "");
  const Chain built = as_built(nominal, {{"geometry", "elbow", {{"length", 0.003}}, {{"axis", "y"}}}});
  Dice dice(23);
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::VectorXd q = dice.vector(2, -3, 3);
    EXPECT_TRUE(forward_kinematics(built, q).isApprox(forward_kinematics(longer, q), 1e-14));
    EXPECT_FALSE(forward_kinematics(built, q).isApprox(forward_kinematics(nominal, q), 1e-4));
  }
}

}  // namespace
}  // namespace qerr
