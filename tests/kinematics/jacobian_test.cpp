#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <filesystem>
#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainjnttojacsolver.hpp>

#include "qerr/input/first_spec.hpp"
#include "qerr/kinematics/chain.hpp"
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

/// The same chain in KDL, one segment per joint of the URDF, with mimics resolved here, independent of
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

struct Gap {
  double pose = 0, jacobian = 0;  ///< largest difference over the largest entry
};

Gap gap_to_kdl(const RobotModel& robot, const Chain& chain, Dice& dice, int configurations) {
  const KdlChain peer(robot, chain.base, chain.tip);
  const std::vector<std::string> names = testing::joint_names(chain);
  Gap gap;
  for (int i = 0; i < configurations; ++i) {
    const Eigen::VectorXd q = testing::random_configuration(dice, chain);
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

// 1e-12 of the largest entry; chains of up to 12 joints with skew axes, prismatic and fixed joints, mimics of
// mimics.
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
    const Eigen::VectorXd q = testing::random_configuration(dice, chain);
    const Jacobian j = jacobian(chain, q);
    const Eigen::Matrix3d r = forward_kinematics(chain, q).linear();
    const double size = std::max(1.0, j.cwiseAbs().maxCoeff());
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      const Eigen::Matrix4d slope = testing::derivative_at_zero([&](double t) -> Eigen::Matrix4d {
        return forward_kinematics(chain, q + t * Eigen::VectorXd::Unit(q.size(), i)).matrix();
      });
      const Eigen::Matrix3d spin = slope.topLeftCorner<3, 3>() * r.transpose();
      Eigen::Matrix<double, 6, 1> column;
      column << slope.topRightCorner<3, 1>(), spin(2, 1), spin(0, 2), spin(1, 0);
      EXPECT_LE((column - j.col(i)).cwiseAbs().maxCoeff(), 1e-9 * size) << "seed " << seed << " joint " << i;
    }
  }
}

}  // namespace
}  // namespace qerr
