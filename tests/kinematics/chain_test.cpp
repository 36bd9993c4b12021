#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <filesystem>
#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainjnttojacsolver.hpp>
#include <map>

#include "qerr/core/error.hpp"
#include "qerr/input/read_urdf.hpp"
#include "qerr/kinematics/coordinates.hpp"
#include "support/random_chain.hpp"

namespace qerr {
namespace {

using testing::ChainMix;
using testing::Dice;
namespace fs = std::filesystem;

const Joint* joint_above(const RobotModel& robot, const std::string& link) {
  for (const Joint& joint : robot.joints)
    if (joint.child == link) return &joint;
  return nullptr;
}

std::vector<std::string> leaves(const RobotModel& robot) {
  std::vector<std::string> ends;
  for (const std::string& link : robot.links) {
    bool is_parent = false;
    for (const Joint& joint : robot.joints) is_parent |= joint.parent == link;
    if (!is_parent) ends.push_back(link);
  }
  return ends;
}

/// The same chain in KDL, one segment per joint of the URDF, with mimics resolved here: nothing of
/// make_chain.
class KdlChain {
 public:
  KdlChain(const RobotModel& robot, const std::string& base, const std::string& tip) {
    std::vector<const Joint*> path;
    for (const Joint* j = joint_above(robot, tip); j;
         j = j->parent == base ? nullptr : joint_above(robot, j->parent))
      path.insert(path.begin(), j);
    for (const Joint* joint : path) {
      const Eigen::Matrix3d& r = joint->origin.linear();
      const KDL::Frame origin(
          KDL::Rotation(r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1), r(1, 2), r(2, 0), r(2, 1), r(2, 2)),
          KDL::Vector(joint->origin(0, 3), joint->origin(1, 3), joint->origin(2, 3)));
      const KDL::Vector axis = origin.M * KDL::Vector(joint->axis.x(), joint->axis.y(), joint->axis.z());
      const auto type = joint->type == JointType::prismatic ? KDL::Joint::TransAxis : KDL::Joint::RotAxis;
      if (joint->type == JointType::fixed) {
        chain_.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::Fixed), origin));
      } else {
        chain_.addSegment(KDL::Segment(KDL::Joint(joint->name, origin.p, axis, type), origin));
        drives_.push_back(drive(robot, *joint));
      }
    }
  }

  /// @param q  value of every independent joint, by name
  void evaluate(const std::vector<std::string>& names, const Eigen::VectorXd& q, Eigen::Isometry3d& pose,
                Jacobian& folded) const {
    KDL::JntArray values(static_cast<unsigned>(drives_.size()));
    for (std::size_t k = 0; k < drives_.size(); ++k)
      values(static_cast<unsigned>(k)) =
          drives_[k].multiplier * q[index(names, drives_[k].joint)] + drives_[k].offset;
    KDL::Frame frame;
    KDL::Jacobian columns(static_cast<unsigned>(drives_.size()));
    KDL::ChainFkSolverPos_recursive(chain_).JntToCart(values, frame);
    KDL::ChainJntToJacSolver(chain_).JntToJac(values, columns);
    pose.setIdentity();
    for (int i = 0; i < 3; ++i) {
      pose(i, 3) = frame.p(i);
      for (int j = 0; j < 3; ++j) pose(i, j) = frame.M(i, j);
    }
    folded = Jacobian::Zero(6, q.size());
    for (std::size_t k = 0; k < drives_.size(); ++k)
      folded.col(index(names, drives_[k].joint)) +=
          drives_[k].multiplier * columns.data.col(static_cast<Eigen::Index>(k));
  }

 private:
  static Mimic drive(const RobotModel& robot, const Joint& joint) {
    if (!joint.mimic) return {joint.name, 1, 0};
    for (const Joint& master : robot.joints)
      if (master.name == joint.mimic->joint) {
        const Mimic above = drive(robot, master);
        return {above.joint, joint.mimic->multiplier * above.multiplier,
                joint.mimic->multiplier * above.offset + joint.mimic->offset};
      }
    throw std::runtime_error("no master of " + joint.name);
  }

  static Eigen::Index index(const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) - names.begin();
  }

  KDL::Chain chain_;
  std::vector<Mimic> drives_;
};

std::vector<std::string> names_of(const Chain& chain) {
  std::vector<std::string> names;
  for (const IndependentJoint& joint : chain.independent) names.push_back(joint.name);
  return names;
}

Eigen::VectorXd random_configuration(Dice& dice, const Chain& chain) {
  Eigen::VectorXd q(static_cast<Eigen::Index>(chain.independent.size()));
  for (Eigen::Index i = 0; i < q.size(); ++i)
    q[i] = chain.independent[static_cast<std::size_t>(i)].prismatic() ? dice.between(-1, 1)
                                                                      : dice.between(-3.2, 3.2);
  return q;
}

struct Gap {
  double pose = 0, jacobian = 0;  ///< largest difference over the largest entry
};

Gap gap_to_kdl(const RobotModel& robot, const Chain& chain, Dice& dice, int configurations) {
  const KdlChain peer(robot, chain.base, chain.tip);
  const std::vector<std::string> names = names_of(chain);
  Gap gap;
  for (int i = 0; i < configurations; ++i) {
    const Eigen::VectorXd q = random_configuration(dice, chain);
    Eigen::Isometry3d pose, with_jacobian;
    Jacobian expected;
    peer.evaluate(names, q, pose, expected);
    const Eigen::Isometry3d ours = forward_kinematics(chain, q);
    joint_jacobian(chain, q, &with_jacobian);
    const double size = pose.matrix().cwiseAbs().maxCoeff();
    gap.pose = std::max({gap.pose, (ours.matrix() - pose.matrix()).cwiseAbs().maxCoeff() / size,
                         (with_jacobian.matrix() - pose.matrix()).cwiseAbs().maxCoeff() / size});
    gap.jacobian = std::max(
        gap.jacobian, (jacobian(chain, q) - expected).cwiseAbs().maxCoeff() / expected.cwiseAbs().maxCoeff());
  }
  return gap;
}

std::vector<std::string> urdfs(const fs::path& folder, bool nested) {
  std::vector<std::string> files;
  if (!fs::is_directory(folder)) return files;
  const auto take = [&](const fs::path& path) {
    if (path.extension() == ".urdf") files.push_back(path.string());
  };
  for (const auto& entry : fs::directory_iterator(folder))
    if (nested && entry.is_directory())
      for (const auto& inner : fs::directory_iterator(entry.path())) take(inner.path());
    else
      take(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

/// @returns number of chains compared
int compare_all_chains(const std::string& file, int configurations) {
  const RobotModel robot = read_urdf(file);
  Dice dice(7);
  int compared = 0;
  for (const std::string& leaf : leaves(robot)) {
    bool moves = false;
    for (const Joint* j = joint_above(robot, leaf); j; j = joint_above(robot, j->parent))
      moves |= j->type != JointType::fixed;
    if (!moves) continue;
    const Gap gap = gap_to_kdl(robot, make_chain(robot, "", leaf), dice, configurations);
    EXPECT_LE(gap.pose, 1e-12) << file << " to " << leaf;
    EXPECT_LE(gap.jacobian, 1e-12) << file << " to " << leaf;
    ++compared;
  }
  return compared;
}

/// f'(0) by five points; error h^4 f'''''/30 and 1e-16/h.
template <class F>
auto derivative_at_zero(const F& f) {
  const double h = 3e-4;
  return ((8 * (f(h) - f(-h)) - (f(2 * h) - f(-2 * h))) / (12 * h)).eval();
}

Eigen::Vector3d roll_pitch_yaw(const Eigen::Matrix3d& r) {
  return {std::atan2(r(2, 1), r(2, 2)), std::asin(-r(2, 0)), std::atan2(r(1, 0), r(0, 0))};
}

Joint link_joint(const std::string& name, JointType type, const std::string& parent,
                 const std::string& child) {
  Joint joint;
  joint.name = name;
  joint.type = type;
  joint.parent = parent;
  joint.child = child;
  joint.origin.translation() << 1, 0, 0;
  joint.axis = Eigen::Vector3d::UnitZ();
  return joint;
}

/// base -a-> one -b-> two -c-> left, two -d-> right: every joint 1 m from the one before, about z.
RobotModel fork() {
  RobotModel robot{"fork", "fork.urdf", {"base", "one", "two", "left", "right"}, {}, {}};
  robot.joints = {link_joint("a", JointType::revolute, "base", "one"),
                  link_joint("b", JointType::revolute, "one", "two"),
                  link_joint("c", JointType::revolute, "two", "left"),
                  link_joint("d", JointType::prismatic, "two", "right")};
  return robot;
}

std::string message_of(const RobotModel& robot, const std::string& base, const std::string& tip) {
  try {
    make_chain(robot, base, tip);
  } catch (const Error& e) {
    EXPECT_EQ(e.trouble(), Trouble::input);
    return e.what();
  }
  return "";
}

TEST(Kinematics, AgreesWithKdlOnEveryShippedRobot) {
  const std::vector<std::string> files = urdfs(fs::path(QERR_SOURCE_DIR) / "configs", true);
  ASSERT_GE(files.size(), 7u);
  for (const std::string& file : files) EXPECT_GE(compare_all_chains(file, 200), 1) << file;
}

TEST(Kinematics, AgreesWithKdlOnEveryChainOfRealRobots) {
  const fs::path folder = fs::path(QERR_SOURCE_DIR) / ".." / "shared" / "robots";
  const std::vector<std::string> files = urdfs(folder, false);
  if (files.empty()) GTEST_SKIP() << "no robots in " << folder;
  for (const std::string& file : files) EXPECT_GE(compare_all_chains(file, 50), 1) << file;
}

// 1e-12 of the largest entry; chains to 12 joints with skew axes, slides, fixed joints and mimics of mimics.
RC_GTEST_PROP(Kinematics, AgreesWithKdlOnRandomChains, ()) {
  Dice dice(*rc::gen::arbitrary<std::uint64_t>());
  ChainMix mix;
  mix.joints = *rc::gen::inRange<std::size_t>(1, 13);
  const RobotModel robot = testing::random_robot(dice, mix);
  const Gap gap = gap_to_kdl(robot, make_chain(robot, "", ""), dice, 5);
  RC_ASSERT(gap.pose <= 1e-12);
  RC_ASSERT(gap.jacobian <= 1e-12);
}

TEST(Jacobian, IsTheDerivativeOfForwardKinematics) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Dice dice(seed);
    const RobotModel robot = testing::random_robot(dice, {});
    const Chain chain = make_chain(robot, "", "");
    const Eigen::VectorXd q = random_configuration(dice, chain);
    const Jacobian j = jacobian(chain, q);
    const Eigen::Matrix3d r = forward_kinematics(chain, q).linear();
    const double size = std::max(1.0, j.cwiseAbs().maxCoeff());
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      const Eigen::Matrix4d slope = derivative_at_zero([&](double t) -> Eigen::Matrix4d {
        return forward_kinematics(chain, q + t * Eigen::VectorXd::Unit(q.size(), i)).matrix();
      });
      const Eigen::Matrix3d spin = slope.topLeftCorner<3, 3>() * r.transpose();
      Eigen::Matrix<double, 6, 1> column;
      column << slope.topRightCorner<3, 1>(), spin(2, 1), spin(0, 2), spin(1, 0);
      EXPECT_LE((column - j.col(i)).cwiseAbs().maxCoeff(), 1e-9 * size) << "seed " << seed << " joint " << i;
    }
  }
}

TEST(Coordinates, RatesOfRollPitchYawAreTheirDerivatives) {
  int compared = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Dice dice(seed);
    const Chain chain = make_chain(testing::random_robot(dice, {}), "", "");
    const Eigen::VectorXd q = random_configuration(dice, chain);
    Eigen::Isometry3d pose;
    const Jacobian joints = joint_jacobian(chain, q, &pose);
    const double cosine = cosine_of_pitch(pose.linear());
    const Eigen::Vector3d here = roll_pitch_yaw(pose.linear());
    EXPECT_NEAR(cosine, std::cos(here.y()), 1e-7);
    if (cosine < 0.3) continue;
    const Eigen::MatrixXd rows = to_independent(
        chain,
        coordinate_rows({Coordinate::roll, Coordinate::pitch, Coordinate::yaw}, joints, pose.linear()));
    for (Eigen::Index i = 0; i < q.size(); ++i, ++compared) {
      const Eigen::Vector3d rate = derivative_at_zero([&](double t) -> Eigen::Vector3d {
        Eigen::Vector3d change =
            roll_pitch_yaw(forward_kinematics(chain, q + t * Eigen::VectorXd::Unit(q.size(), i)).linear()) -
            here;
        for (double& angle : change) angle = std::remainder(angle, 2 * std::numbers::pi);
        return change;
      });
      EXPECT_LE((rate - rows.col(i)).cwiseAbs().maxCoeff(), 1e-7 / std::pow(cosine, 3)) << "seed " << seed;
    }
  }
  EXPECT_GT(compared, 300);
}

TEST(Coordinates, RollAndYawAreUnboundedAtTheGimbalLockAndPitchIsNot) {
  Jacobian j = Jacobian::Zero(6, 1);
  j.col(0) << 1, 2, 3, 4, 5, 6;
  const Eigen::Matrix3d up =
      Eigen::AngleAxisd(-std::numbers::pi / 2, Eigen::Vector3d::UnitY()).toRotationMatrix();
  Eigen::Matrix3d lock = up;
  lock(0, 0) = lock(1, 0) = 0;
  const Eigen::MatrixXd rows = coordinate_rows(
      {Coordinate::roll, Coordinate::pitch, Coordinate::yaw, Coordinate::y, Coordinate::rz}, j, lock);
  EXPECT_EQ(rows(0, 0), std::numeric_limits<double>::infinity());
  EXPECT_EQ(rows(1, 0), 5);
  EXPECT_EQ(rows(2, 0), std::numeric_limits<double>::infinity());
  EXPECT_EQ(rows(3, 0), 2);
  EXPECT_EQ(rows(4, 0), 6);
}

TEST(Coordinates, NamesAreFoundAndUnknownOnesAreNot) {
  for (const CoordinateInfo& row : coordinate_list()) {
    EXPECT_EQ(find_coordinate(row.name), row.coordinate);
    EXPECT_EQ(info(row.coordinate).name, row.name);
    EXPECT_EQ(row.unit, is_position(row.coordinate) ? "m" : "rad");
  }
  EXPECT_EQ(coordinate_list().size(), 9u);
  EXPECT_FALSE(find_coordinate("X"));
}

TEST(Chain, MimicFoldsIntoItsMaster) {
  RobotModel robot = fork();
  robot.joints[1].mimic = Mimic{"a", -0.5, 0.25};  // b = 0.25 - a/2
  const Chain chain = make_chain(robot, "base", "left");
  ASSERT_EQ(names_of(chain), (std::vector<std::string>{"a", "c"}));
  ASSERT_EQ(chain.joints.size(), 3u);
  // By hand: tip = (1,0) + Rz(a)(1,0) + Rz(a+b)(1,0); its rotation is a + b + c.
  const double a = 0.3, c = -0.7, b = 0.25 - 0.5 * a;
  const Eigen::Isometry3d pose = forward_kinematics(chain, Eigen::Vector2d(a, c));
  EXPECT_NEAR(pose(0, 3), 1 + std::cos(a) + std::cos(a + b), 1e-15);
  EXPECT_NEAR(pose(1, 3), std::sin(a) + std::sin(a + b), 1e-15);
  const Jacobian j = jacobian(chain, Eigen::Vector2d(a, c));
  EXPECT_NEAR(j(0, 0), -std::sin(a) - 0.5 * std::sin(a + b), 1e-15);
  EXPECT_NEAR(j(1, 0), std::cos(a) + 0.5 * std::cos(a + b), 1e-15);
  EXPECT_NEAR(j(5, 0), 0.5, 1e-15);
  EXPECT_NEAR(j(5, 1), 1, 1e-15);
}

TEST(Chain, MasterBesideTheChainIsIndependentAllTheSame) {
  RobotModel robot = fork();
  robot.joints[2].mimic = Mimic{"d", 2, 0};  // c follows the slide on the other branch
  const Chain chain = make_chain(robot, "one", "left");
  ASSERT_EQ(names_of(chain), (std::vector<std::string>{"b", "d"}));
  EXPECT_FALSE(chain.independent[1].on_chain);
  EXPECT_TRUE(chain.independent[1].prismatic());
  EXPECT_FALSE(chain.joints[1].prismatic);
  EXPECT_EQ(jacobian(chain, Eigen::Vector2d(0.1, 0.2))(5, 1), 2);
}

TEST(Chain, FindsItsJointsByName) {
  RobotModel robot = fork();
  robot.joints[2].mimic = Mimic{"d", 2, 0};  // c follows the slide on the other branch
  const Chain chain = make_chain(robot, "one", "left");
  EXPECT_EQ(independent_index(chain, "b"), 0u);
  EXPECT_EQ(independent_index(chain, "d"), 1u);
  EXPECT_THROW(independent_index(chain, "c"), std::out_of_range) << "a mimic";
  EXPECT_THROW(independent_index(chain, "a"), std::out_of_range) << "below the base";
  EXPECT_EQ(find_joint(chain, "b"), std::optional<std::size_t>{0});
  EXPECT_EQ(find_joint(chain, "c"), std::optional<std::size_t>{1});
  EXPECT_FALSE(find_joint(chain, "d")) << "a master beside the chain";
}

TEST(Chain, MasterBehindItsMimicTakesItsOwnPlace) {
  RobotModel robot = fork();
  robot.joints[0].mimic = Mimic{"c", 1, 0};
  const Chain chain = make_chain(robot, "base", "left");
  EXPECT_EQ(names_of(chain), (std::vector<std::string>{"b", "c"}));
  EXPECT_TRUE(chain.independent[1].on_chain);
}

TEST(Chain, RunsInsideATree) {
  const Chain chain = make_chain(fork(), "one", "right");
  EXPECT_EQ(chain.base, "one");
  EXPECT_EQ(chain.tip, "right");
  ASSERT_EQ(names_of(chain), (std::vector<std::string>{"b", "d"}));
  const Eigen::Isometry3d pose = forward_kinematics(chain, Eigen::Vector2d(std::numbers::pi / 2, 0.5));
  EXPECT_NEAR(pose(0, 3), 1, 1e-15);
  EXPECT_NEAR(pose(1, 3), 1, 1e-15);
  EXPECT_NEAR(pose(2, 3), 0.5, 1e-15);
}

TEST(Chain, SeveralLeavesNeedATip) {
  const std::string message = message_of(fork(), "", "");
  EXPECT_NE(message.find("robot.tip"), std::string::npos) << message;
  EXPECT_NE(message.find("'left', 'right'"), std::string::npos) << message;
}

TEST(Chain, FloatingAndPlanarJointsOnTheWayAreRefusedByName) {
  for (const auto& [type, word] :
       {std::pair{JointType::floating, "floating"}, {JointType::planar, "planar"}}) {
    RobotModel robot = fork();
    robot.joints[1].type = type;
    const std::string message = message_of(robot, "", "left");
    EXPECT_NE(message.find("joint 'b'"), std::string::npos) << message;
    EXPECT_NE(message.find(word), std::string::npos) << message;
    EXPECT_EQ(make_chain(robot, "two", "left").joints.size(), 1u) << "beside the way it does no harm";
  }
}

TEST(Chain, UnknownLinksAndChainsWithoutMotionAreRefused) {
  EXPECT_NE(message_of(fork(), "bse", "left").find("'base'"), std::string::npos) << "suggests a name";
  EXPECT_NE(message_of(fork(), "", "middle").find("robot.tip"), std::string::npos);
  EXPECT_NE(message_of(fork(), "two", "two").find("robot.tip"), std::string::npos);
  EXPECT_NE(message_of(fork(), "left", "right").find("robot.tip"), std::string::npos) << "beside the base";
  EXPECT_NE(message_of(fork(), "two", "one").find("robot.tip"), std::string::npos) << "above the base";
  RobotModel still = fork();
  still.joints[2].type = JointType::fixed;
  EXPECT_NE(message_of(still, "two", "left").find("nothing moves"), std::string::npos);
}

}  // namespace
}  // namespace qerr
