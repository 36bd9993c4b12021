#include "bound/proven/chain_bound.hpp"

#include <gtest/gtest.h>

#include <map>
#include <numbers>

#include "support/figure_search.hpp"
#include "support/random_model.hpp"

namespace qerr {
namespace {

using std::numbers::pi;
using testing::ChainMix;
using testing::Dice;

/// Index among the coordinates and lengths of the models below.
constexpr std::size_t x = 0, rx = 3, xyz = 6, rxyz = 7;

OperationalModel model_of(const RobotModel& robot) {
  OperationalModel m{make_chain(robot, "", ""), {}, {}};
  const auto n = static_cast<Eigen::Index>(m.chain.independent.size());
  m.transmission.coupling = Eigen::MatrixXd::Identity(n, n);
  m.transmission.encoders.resize(static_cast<std::size_t>(n), Encoder{1e-4});
  m.coordinates = {Coordinate::x,  Coordinate::y,  Coordinate::z,
                   Coordinate::rx, Coordinate::ry, Coordinate::rz};
  m.lengths = {Coordinate::xyz, Coordinate::rxyz};
  return m;
}

/// Joints about z at the ends of links of these lengths along x.
OperationalModel planar_arm(const std::vector<double>& lengths) {
  RobotModel robot{"planar", "planar.urdf", {"base"}, {}, {}};
  Eigen::Isometry3d at = Eigen::Isometry3d::Identity();
  for (std::size_t i = 0; i <= lengths.size(); ++i) {
    const bool tip = i == lengths.size();
    const std::string link = "link_" + std::to_string(i);
    robot.joints.push_back({"joint_" + std::to_string(i),
                            tip ? JointType::fixed : JointType::revolute,
                            robot.links.back(),
                            link,
                            at,
                            Eigen::Vector3d::UnitZ(),
                            {},
                            {},
                            {}});
    robot.links.push_back(link);
    if (!tip) at.translation() = lengths[i] * Eigen::Vector3d::UnitX();
  }
  return model_of(robot);
}

std::vector<Limits> random_ranges(Dice& dice, const OperationalModel& m) {
  std::vector<Limits> ranges;
  for (const IndependentJoint& joint : m.chain.independent) {
    const double middle = dice.between(-2, 2);
    const double half = joint.prismatic()  ? dice.between(0, 0.4)
                        : dice.chance(0.2) ? pi
                        : dice.chance(0.1) ? 0
                                           : dice.between(0, 3);
    ranges.push_back({middle - half, middle + half});
  }
  return ranges;
}

void expect_at_least(const OperationalModel& m, const std::vector<Limits>& ranges, const Figure& request,
                     double gap, double promised) {
  const double lower = testing::largest_figure(m, ranges, request, 150, 5);
  const std::optional<double> upper = chain_upper_bound(m, ranges, request, lower, gap);
  ASSERT_TRUE(upper);
  EXPECT_GE(*upper, lower * (1 - 1e-12)) << request.signal;
  EXPECT_LE(*upper, lower * (1 + promised)) << request.signal;
}

TEST(ChainBound, OfOneJointIsItsRadiusTimesItsWidth) {
  const OperationalModel m = planar_arm({0.7});
  const std::vector<Limits> turn{{-pi, pi}};
  for (const std::size_t c : {x, xyz}) {
    const double worst = *chain_upper_bound(m, turn, {c, -1, Bound::worst_case}, 0.7 * 0.5e-4, 1e-4);
    EXPECT_NEAR(worst / (0.7 * 0.5e-4), 1, 1e-3);
    EXPECT_GE(worst, 0.7 * 0.5e-4);
  }
  EXPECT_NEAR(*chain_upper_bound(m, turn, {xyz, -1, Bound::sigma}, 0, 0.01), 0.7e-4 / std::sqrt(12.0), 1e-12);
}

TEST(ChainBound, OfAPlanarArmIsThatOfTheStretchedArm) {
  // dx = -sum over joints of dq_k (y of the tip beyond joint k): all links along y.
  const OperationalModel m = planar_arm({0.5, 0.3, 0.2});
  const std::vector<Limits> turn(3, {-pi, pi});
  const double worst = 0.5e-4 * (1.0 + 0.5 + 0.2);
  const double sigma = 1e-4 / std::sqrt(12.0) * std::sqrt(1.0 + 0.25 + 0.04);
  EXPECT_NEAR(*chain_upper_bound(m, turn, {x, -1, Bound::worst_case}, worst, 0.001) / worst, 1.001, 0.0011);
  EXPECT_NEAR(*chain_upper_bound(m, turn, {xyz, -1, Bound::worst_case}, worst, 0.001) / worst, 1.001, 0.0011);
  EXPECT_NEAR(*chain_upper_bound(m, turn, {xyz, -1, Bound::sigma}, sigma, 0.001) / sigma, 1.0005, 0.0006);
}

TEST(ChainBound, EndsOfTheRangeCount) {
  // dx = -dq (0.7 sin q), largest at the end of the range.
  const OperationalModel m = planar_arm({0.7});
  const double worst = 0.5e-4 * 0.7 * std::sin(0.4);
  EXPECT_NEAR(*chain_upper_bound(m, {{-0.1, 0.4}}, {x, -1, Bound::worst_case}, worst, 0.001) / worst, 1.0005,
              0.0006);
}

void add_sources(Dice& dice, OperationalModel& m, bool origins) {
  const auto owner = [&] { return dice.below(m.chain.independent.size()); };
  m.sources.push_back({.where = IndependentError::Where::joint,
                       .owner = owner(),
                       .mean = dice.chance(0.5) ? 3e-5 : 0,
                       .half_width = 2e-5,
                       .sigma = 1e-5});
  m.sources.push_back(
      {.where = IndependentError::Where::encoder, .owner = owner(), .half_width = 3e-5, .sigma = 2e-5});
  if (origins)
    m.sources.push_back(testing::in_parent_link({.where = IndependentError::Where::origin,
                                                 .owner = owner(),
                                                 .link = dice.below(m.chain.joints.size()),
                                                 .direction = dice.direction(),
                                                 .mean = dice.chance(0.5) ? 1e-5 : 0,
                                                 .half_width = 2e-5,
                                                 .sigma = 1e-5},
                                                m.chain));
}

TEST(ChainBound, HoldsWithoutLeversAndWithoutTurns) {
  OperationalModel wrist = planar_arm({0, 0});  // the tip is on all axes
  const std::vector<Limits> turn(2, {-pi, pi});
  OperationalModel slides = wrist;
  for (ChainJoint& joint : slides.chain.joints) joint.prismatic = true, joint.axis = Eigen::Vector3d::UnitX();
  for (const CoordinateFrame frame : {CoordinateFrame::base, CoordinateFrame::tip}) {
    wrist.frame = slides.frame = frame;
    for (const Bound figure : {Bound::worst_case, Bound::sigma})
      for (const std::size_t c : {x, xyz}) {
        EXPECT_NEAR(*chain_upper_bound(wrist, turn, {c, -1, figure}, 0, 0.01), 0, 1e-9);
        const double sum = figure == Bound::sigma ? 1e-4 / std::sqrt(6.0) : 1e-4;
        const double bound = *chain_upper_bound(slides, turn, {c, -1, figure}, sum, 0.01);
        EXPECT_GE(bound, sum * (1 - 1e-12));
        EXPECT_LE(bound, sum * 1.01);
      }
  }
}

TEST(ChainBound, IsNeverBelowASearchOfRandomChains) {
  Dice dice(21);
  for (int i = 0; i < 2; ++i) {
    SCOPED_TRACE(i);
    OperationalModel m = model_of(testing::random_robot(dice, ChainMix{3 + dice.below(2), 0.25, 0}));
    m.transmission = testing::random_transmission(dice, m.chain, 1e-5, 1e-3, false);
    m.frame = i % 2 == 0 ? CoordinateFrame::base : CoordinateFrame::tip;
    const std::vector<Limits> ranges = random_ranges(dice, m);
    for (const std::size_t c : {x, rx, xyz, rxyz}) {
      expect_at_least(m, ranges, {c, -1, Bound::worst_case}, 0.03, 0.03);
      expect_at_least(m, ranges, {c, -1, Bound::sigma}, 0.03, 0.03);
    }
  }
}

TEST(ChainBound, IsNeverBelowASearchOfChainsWithSources) {
  Dice dice(23);
  for (int i = 0; i < 3; ++i) {
    SCOPED_TRACE(i);
    OperationalModel m = model_of(testing::random_robot(dice, ChainMix{2 + dice.below(3), 0.25, 0}));
    m.transmission = testing::random_transmission(dice, m.chain, 1e-5, 1e-4, false);
    m.frame = i % 2 == 0 ? CoordinateFrame::base : CoordinateFrame::tip;
    add_sources(dice, m, true);
    SignalMoments tip{Eigen::VectorXd::Zero(6), dice.vector(6, 0, 1e-5), Eigen::MatrixXd::Zero(6, 6)};
    tip.covariance.diagonal() = tip.peak.cwiseAbs2() / 3;
    const auto joints = static_cast<Eigen::Index>(m.chain.independent.size());
    m.along_motion = ErrorAlongMotion{
        {Eigen::VectorXd::Zero(joints), Eigen::VectorXd::Zero(joints), Eigen::MatrixXd::Zero(joints, joints)},
        tip,
        {}};
    const std::vector<Limits> ranges = random_ranges(dice, m);
    for (const std::size_t c : {x, rx})
      // The finest grid for a gap keeps it for most chains only.
      for (const Bound figure : {Bound::worst_case, Bound::sigma})
        expect_at_least(m, ranges, {c, -1, figure}, 0.03, 0.035);
  }
}

TEST(ChainBound, IsNeverBelowASearchOfCoupledAndMimicJoints) {
  Dice dice(22);
  for (int i = 0; i < 4; ++i) {
    SCOPED_TRACE(i);
    OperationalModel m =
        model_of(testing::random_robot(dice, ChainMix{2 + dice.below(2), 0.2, i % 2 == 0 ? 0 : 0.7}));
    m.transmission = testing::random_transmission(dice, m.chain, 1e-5, 1e-3, i % 2 == 0);
    m.frame = i % 4 < 2 ? CoordinateFrame::base : CoordinateFrame::tip;
    const std::vector<Limits> ranges = random_ranges(dice, m);
    for (const std::size_t c : {x, rx, xyz, rxyz}) {
      expect_at_least(m, ranges, {c, -1, Bound::worst_case}, 0.06, 0.06);
      // Errors that move distant joints are relaxed.
      const bool distant = m.chain.joints.size() > 2 && m.chain.independent.size() > 1;
      expect_at_least(m, ranges, {c, -1, Bound::sigma}, 0.06, distant ? 1 : 0.06);
    }
  }
}

/// A differential between two neighbours of three joints.
TEST(ChainBound, IsReachedByCouplingsOfNeighbours) {
  Dice dice(24);
  for (int i = 0; i < 6; ++i) {
    SCOPED_TRACE(i);
    OperationalModel m = model_of(testing::random_robot(dice, ChainMix{3, 0.2, 0}));
    const Eigen::Index first = i % 2, last = first + 1;
    Eigen::MatrixXd coupling = m.transmission.coupling.dense();
    coupling(first, last) = coupling(last, last) = coupling(first, first) = 0.5;
    coupling(last, first) = -0.5;
    m.transmission.coupling = coupling;
    m.frame = i < 3 ? CoordinateFrame::base : CoordinateFrame::tip;
    const std::vector<Limits> ranges = random_ranges(dice, m);
    for (const std::size_t c : {x, rx, xyz, rxyz})
      for (const Bound figure : {Bound::worst_case, Bound::sigma})
        expect_at_least(m, ranges, {c, -1, figure}, 0.03, 0.03);
  }
}

/// On grids of a few cells every allowance is large: without it, or with tables too small for what is looked
/// up, some figure would come out too small.
TEST(ChainBound, IsNeverBelowASearchOnTheCoarsestGrids) {
  Dice dice(25);
  for (int i = 0; i < 4; ++i) {
    SCOPED_TRACE(i);
    OperationalModel m = model_of(testing::random_robot(dice, ChainMix{1 + dice.below(4), 0.2, 0}));
    m.transmission = testing::random_transmission(dice, m.chain, 1e-5, 1e-4, i % 3 == 0);
    m.frame = i % 2 == 0 ? CoordinateFrame::base : CoordinateFrame::tip;
    const std::vector<Limits> ranges = random_ranges(dice, m);
    const ChainForm form = chain_form(m, ranges);
    const std::vector<Eigen::Vector3d> along_x{Eigen::Vector3d::UnitX()};
    const bool tip = i % 2 != 0;
    const RotationAxes axes = tip ? RotationAxes::tip : RotationAxes::base;
    std::map<std::pair<std::size_t, Bound>, double> lower;
    for (const std::size_t c : {x, rx, xyz, rxyz})
      for (const Bound figure : {Bound::worst_case, Bound::sigma})
        lower[{c, figure}] = testing::largest_figure(m, ranges, {c, -1, figure}, 60, 5);
    const auto expect = [&](std::size_t c, Bound figure, double bound) {
      EXPECT_GE(bound, (lower[{c, figure}] * (1 - 1e-12))) << c << (figure == Bound::sigma);
    };
    for (const double cells : {2.0, 3.0, 5.0}) {
      const PositionWorstCase worst = position_worst_case_bound(form, along_x, cells);
      expect(xyz, Bound::worst_case, worst.length);
      expect(xyz, Bound::sigma, position_sigma_bound(form, cells));
      expect(x, Bound::worst_case,
             tip ? tip_component_bound(form, TipFigure::worst_case, along_x, cells)[0] : worst.along[0]);
      expect(x, Bound::sigma,
             tip ? tip_component_bound(form, TipFigure::sigma, along_x, cells)[0]
                 : component_sigma_bound(form, along_x, cells)[0]);
      expect(rx, Bound::worst_case, rotation_worst_case_bound(form, axes, along_x, cells).along[0]);
      expect(rx, Bound::sigma, rotation_sigma_bound(form, axes, along_x, cells).along[0]);
      expect(rxyz, Bound::worst_case, rotation_worst_case_bound(form, RotationAxes::base, {}, cells).length);
    }
  }
}

}  // namespace
}  // namespace qerr
