#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>

#include "qerr/bound/workspace.hpp"
#include "support/random_model.hpp"
#include "support/workspace_figures.hpp"

// Properties of the bounds that hold for every robot. Unless said otherwise two figures are equal to 1e-13 of
// what all joint errors at the largest lever arm would cause: at most 9 joints with a fixed one each, whose
// transforms are products of sums of three terms, round it less than 900 times, by 1.1e-16 each.
namespace qerr {
namespace {

using testing::Dice;
using testing::same_figures;

constexpr double rounding_of_sums = 1e-13;

/// A random robot, its encoders, its filters and configurations.
struct RobotCase {
  RobotModel robot;
  OperationalModel model;
  std::vector<Norms> filters;
  Configurations configurations;
};

const std::vector<Coordinate> all_of_pose{Coordinate::x,  Coordinate::y,  Coordinate::z,
                                          Coordinate::rx, Coordinate::ry, Coordinate::rz};

/// Norms that a filter can have: |H(1)| and ||H||_2 are at most ||H||_1.
Norms random_norms(Dice& dice) {
  const double l1 = dice.between(1, 1e3);
  return {dice.between(0, l1), 0, {l1, l1}, dice.between(-l1, l1)};
}

Configurations listed(Dice& dice, const Chain& chain, std::size_t count) {
  Configurations c{.method = SamplingMethod::list, .count = count, .ranges = {}};
  for (const IndependentJoint& joint : chain.independent)
    c.ranges.push_back(joint.prismatic() ? Limits{-1, 1} : Limits{-3.2, 3.2});
  for (std::size_t i = 0; i < count; ++i) c.points.push_back(testing::random_configuration(dice, chain));
  return c;
}

/// @param mixed  with errors other than quantization
RobotCase drawn_case(Dice& dice, double mimic, bool mixed) {
  testing::ChainMix mix{1 + dice.below(7)};
  mix.mimic = mimic;
  mix.square = dice.chance(0.5) ? 1 : 0;
  RobotCase r{testing::random_robot(dice, mix), {}, {random_norms(dice), random_norms(dice)}, {}};
  // A tool, so that no lever arm vanishes next to the rounding of other lengths.
  r.robot.joints.back().origin.translation() = dice.between(0.1, 0.5) * dice.axis();
  r.model = {make_chain(r.robot, "", ""), {}, all_of_pose};
  r.model.transmission = testing::random_transmission(dice, r.model.chain, 1e-5, 1e-2, dice.chance(0.5));
  r.model.lengths = {Coordinate::xyz, Coordinate::rxyz};
  if (dice.chance(0.3)) r.model.frame = CoordinateFrame::tip;
  for (std::size_t i = mixed ? dice.below(4) : 0; i > 0; --i)
    r.model.sources.push_back(testing::random_source(dice, r.model.chain, r.filters.size()));
  r.configurations = listed(dice, r.model.chain, 1 + dice.below(40));
  return r;
}

Workspace evaluated(const RobotCase& r) { return workspace(r.model, r.filters, r.configurations, {1}); }

std::vector<testing::WorkspaceFigure> listed_figures(const RobotCase& r, const Workspace& w,
                                                     std::size_t first = 0) {
  return testing::workspace_figures(r.model, r.filters, r.configurations.ranges, w, first);
}

std::vector<testing::WorkspaceFigure> figures_of(const RobotCase& r) {
  return listed_figures(r, evaluated(r));
}

// The box of the encoders' errors of a finer encoder lies within that of a coarser one, whether it rounds to
// nearest or down; a worst case is the largest error over that box, so that it cannot rise, and |H(1)| <=
// ||H||_1 says the same behind a filter. A statistic over the configurations rises with the values only.
RC_GTEST_PROP(ModelProperties, AFinerEncoderNeverRaisesABound, ()) {
  Dice dice(*rc::gen::arbitrary<std::uint64_t>());
  RobotCase r = drawn_case(dice, 0.2, true);
  const std::vector<testing::WorkspaceFigure> coarse = figures_of(r);
  for (Encoder& encoder : r.model.transmission.encoders)
    if (dice.chance(0.6)) encoder.resolution *= dice.between(0, 1);
  const std::vector<testing::WorkspaceFigure> fine = figures_of(r);
  RC_ASSERT(coarse.size() == fine.size());
  for (std::size_t i = 0; i < fine.size(); ++i)
    RC_ASSERT(fine[i].value <= coarse[i].value + rounding_of_sums * coarse[i].size);
}

/// The robot `factor` times as large.
RobotCase enlarged(const RobotCase& r, double factor) {
  RobotCase large = r;
  const auto slides = [](const Chain& chain, std::size_t i) { return chain.independent[i].prismatic(); };
  const Chain& chain = r.model.chain;
  for (ChainJoint& joint : large.model.chain.joints) {
    joint.origin.translation() *= factor;
    if (joint.prismatic) joint.multiplier *= factor, joint.offset *= factor;
    if (slides(chain, joint.coordinate)) joint.multiplier /= factor;
  }
  large.model.chain.tip_offset.translation() *= factor;
  Transmission& t = large.model.transmission;
  Eigen::MatrixXd coupling = t.coupling.dense();
  for (std::size_t i = 0; i < t.encoders.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    if (!slides(chain, i)) continue;
    t.encoders[i].resolution *= factor;
    coupling.row(at) *= factor;
    coupling.col(at) /= factor;
    large.configurations.ranges[i].lower *= factor;
    large.configurations.ranges[i].upper *= factor;
    for (Eigen::VectorXd& point : large.configurations.points) point[at] *= factor;
  }
  t.coupling = coupling;
  for (IndependentError& s : large.model.sources)
    if (s.where == IndependentError::Where::origin || slides(chain, s.owner))
      s.mean *= factor, s.half_width *= factor, s.sigma *= factor;
  return large;
}

// Powers of two multiply doubles exactly, so that an absolute threshold anywhere in the computation would be
// seen as a difference; another factor is rounded.
RC_GTEST_PROP(ModelProperties, ALargerRobotHasLargerPositionErrorsAndTheSameRotationErrors, ()) {
  Dice dice(*rc::gen::arbitrary<std::uint64_t>());
  const RobotCase r = drawn_case(dice, 0.2, true);
  const double power = std::exp2(static_cast<double>(dice.below(21)) - 10), other = dice.between(0.01, 100);
  const std::vector<testing::WorkspaceFigure> original = figures_of(r);
  RC_ASSERT(testing::figures_scale(original, figures_of(enlarged(r, power)), power, 1, 0));
  RC_ASSERT(testing::figures_scale(original, figures_of(enlarged(r, other)), other, 1, rounding_of_sums));
}

/// The robot on a base that stands elsewhere. Sources keep their directions, which are in the axes of links.
RobotCase mounted(const RobotCase& r, const Eigen::Isometry3d& place) {
  RobotCase moved = r;
  Joint mount;
  mount.name = "mount";
  mount.parent = "world";
  mount.child = r.robot.links.front();
  mount.origin = place;
  moved.robot.links.insert(moved.robot.links.begin(), "world");
  moved.robot.joints.insert(moved.robot.joints.begin(), mount);
  moved.model.chain = make_chain(moved.robot, "", "");
  for (IndependentError& s : moved.model.sources)  // the same in the joint's parent link
    if (s.where == IndependentError::Where::origin)
      s.direction = moved.model.chain.joints[s.link].parent_axes *
                    r.model.chain.joints[s.link].parent_axes.transpose() * s.direction;
  return moved;
}

// Where the base stands says nothing about the lengths of the errors, nor about their components in the axes
// of the tip; those in the axes of the base rotate with it.
RC_GTEST_PROP(ModelProperties, TheErrorRotatesWithTheBaseAndKeepsItsLength, ()) {
  Dice dice(*rc::gen::arbitrary<std::uint64_t>());
  const RobotCase r = drawn_case(dice, 0.2, true);
  const Eigen::Isometry3d place = dice.frame(10);
  const RobotCase moved = mounted(r, place);
  const Workspace before = evaluated(r), after = evaluated(moved);
  const bool in_tip = r.model.frame == CoordinateFrame::tip;
  const std::size_t first = in_tip ? 0 : all_of_pose.size();  // that the base's axes leave alone
  RC_ASSERT(
      same_figures(listed_figures(r, before, first), listed_figures(moved, after, first), rounding_of_sums));
  if (in_tip) return;
  Eigen::MatrixXd rotation = Eigen::MatrixXd::Zero(6, 6);
  rotation.topLeftCorner<3, 3>() = rotation.bottomRightCorner<3, 3>() = place.linear();
  // Lever arms of the mounted robot are differences of points that are rounded relative to the whole extent.
  const auto largest = [&](bool metres) {
    return testing::largest_sum(moved.model, r.configurations.ranges, metres);
  };
  Eigen::VectorXd size(6);
  size << Eigen::Vector3d::Constant(largest(true)), Eigen::Vector3d::Constant(largest(false));
  for (const Eigen::VectorXd& q : r.configurations.points) {
    const OperationalError e = operational_error(r.model, q), f = operational_error(moved.model, q);
    const Eigen::ArrayXd mean = (rotation * e.mean - f.mean).array().abs();
    RC_ASSERT((mean <= rounding_of_sums * size.array()).all());
    const Eigen::ArrayXXd squares =
        (rotation * covariance(e) * rotation.transpose() - covariance(f)).array().abs();
    RC_ASSERT((squares <= rounding_of_sums * (size * size.transpose()).array()).all());
  }
}

/// The robot with fixed joints in between: each origin is a product of two.
RobotModel with_fixed_joints(Dice& dice, const RobotModel& robot, bool trivial) {
  RobotModel more = robot;
  more.joints.clear();
  for (Joint joint : robot.joints) {
    if (dice.chance(0.5)) {
      Joint fixed;
      fixed.name = "before_" + joint.name;
      fixed.parent = joint.parent;
      fixed.child = joint.parent = "link_before_" + joint.name;
      if (!trivial) fixed.origin = dice.frame(0.1);
      joint.origin = fixed.origin.inverse() * joint.origin;
      more.joints.push_back(fixed);
      more.links.push_back(fixed.child);
    }
    more.joints.push_back(joint);
  }
  return more;
}

// A joint that does not move is no part of the chain's kinematics. An identity is not rounded, but a product
// with it loses the sign of a zero, and with it an angle of -pi, whose sum with that of a joint is rounded.
RC_GTEST_PROP(ModelProperties, FixedJointsChangeNothing, ()) {
  Dice dice(*rc::gen::arbitrary<std::uint64_t>());
  RobotCase r = drawn_case(dice, 0.2, false);
  const std::vector<testing::WorkspaceFigure> without = figures_of(r);
  for (const bool trivial : {true, false}) {
    r.model.chain = make_chain(with_fixed_joints(dice, r.robot, trivial), "", "");
    RC_ASSERT(same_figures(without, figures_of(r), rounding_of_sums));
  }
}

/// The same robot, whose mimic joints move by themselves, coupled to their masters: C has their multipliers.
/// Encoders of 1e-30 on the mimic joints keep it invertible and add nothing.
RobotCase coupled_in_place_of_mimics(const RobotCase& r) {
  RobotCase c = r;
  for (Joint& joint : c.robot.joints) joint.mimic.reset();
  c.model.chain = make_chain(c.robot, "", "");
  const std::vector<ChainJoint>& joints = r.model.chain.joints;
  const auto n = static_cast<Eigen::Index>(joints.size());
  const auto own = [&](std::size_t k) {
    return r.model.chain.independent[joints[k].coordinate].name == joints[k].name;
  };
  const auto column = [&](std::size_t coordinate) {  // of the joint that has the coordinate
    return static_cast<Eigen::Index>(
        independent_index(c.model.chain, r.model.chain.independent[coordinate].name));
  };
  Transmission& t = c.model.transmission;
  t.encoders.assign(joints.size(), Encoder{1e-30});
  Eigen::MatrixXd coupling = Eigen::MatrixXd::Zero(n, n);
  c.configurations.ranges.assign(joints.size(), {-10, 10});
  c.configurations.points.assign(r.configurations.points.size(), Eigen::VectorXd(n));
  for (std::size_t k = 0; k < joints.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(independent_index(c.model.chain, joints[k].name));
    const auto master = static_cast<Eigen::Index>(joints[k].coordinate);
    if (own(k))
      t.encoders[static_cast<std::size_t>(row)] = r.model.transmission.encoders[joints[k].coordinate];
    else
      coupling(row, row) = 1;
    for (std::size_t e = 0; e < r.model.chain.independent.size(); ++e)
      coupling(row, column(e)) +=
          joints[k].multiplier * r.model.transmission.coupling(master, static_cast<Eigen::Index>(e));
    for (std::size_t i = 0; i < c.configurations.points.size(); ++i)
      c.configurations.points[i][row] =
          joints[k].multiplier * r.configurations.points[i][master] + joints[k].offset;
  }
  t.coupling = coupling;
  return c;
}

RC_GTEST_PROP(ModelProperties, AMimicJointIsACoupling, ()) {
  Dice dice(*rc::gen::arbitrary<std::uint64_t>());
  const RobotCase r = drawn_case(dice, 0.6, false);
  RC_CLASSIFY(r.model.chain.independent.size() < r.model.chain.joints.size(), "with mimic joints");
  RC_ASSERT(same_figures(figures_of(r), figures_of(coupled_in_place_of_mimics(r)), rounding_of_sums));
}

// What each thread computes depends on the configurations alone.
RC_GTEST_PROP(ModelProperties, ThreadsChangeNoBit, ()) {
  Dice dice(*rc::gen::arbitrary<std::uint64_t>());
  RobotCase r = drawn_case(dice, 0.2, true);
  r.configurations.method = dice.chance(0.5) ? SamplingMethod::sobol : SamplingMethod::random;
  r.configurations.count = 1 + dice.below(3000);
  const Workspace one = evaluated(r);
  const Workspace several =
      workspace(r.model, r.filters, r.configurations, {.threads = 2 + static_cast<unsigned>(dice.below(4))});
  RC_ASSERT(same_figures(listed_figures(r, one), listed_figures(r, several), 0));
  RC_ASSERT(one.mean_covariance == several.mean_covariance && one.largest_at == several.largest_at);
}

}  // namespace
}  // namespace qerr
