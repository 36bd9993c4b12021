#include "qerr/bound/proven_maximum.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "bound/proven/ascent.hpp"
#include "core/parallel.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/bound/workspace.hpp"
#include "qerr/core/error.hpp"
#include "qerr/filter/family.hpp"
#include "support/design_filter.hpp"
#include "support/random_chain.hpp"
#include "support/random_model.hpp"

namespace qerr {
namespace {

using testing::ChainMix;
using testing::Dice;

using std::numbers::pi;

Limits random_range(Dice& dice, bool prismatic) {
  if (prismatic) return {dice.between(-0.3, 0), dice.between(0.05, 0.4)};
  return {dice.between(-3, -0.5), dice.between(0.2, 3)};
}

std::vector<Limits> random_ranges(Dice& dice, const Chain& chain) {
  std::vector<Limits> ranges;
  for (const IndependentJoint& joint : chain.independent)
    ranges.push_back(random_range(dice, joint.prismatic()));
  return ranges;
}

/// Positions, rotations and lengths, in the base or the tip; couplings, mimics, sources, counters that round
/// down.
OperationalModel random_model(Dice& dice, std::size_t joints) {
  OperationalModel m{make_chain(testing::random_robot(dice, ChainMix{joints}), "", ""), {}, {}};
  m.transmission = testing::random_transmission(dice, m.chain, 1e-4, 1e-3, dice.chance(0.5));
  m.coordinates = {Coordinate::x,  Coordinate::y,  Coordinate::z,
                   Coordinate::rx, Coordinate::ry, Coordinate::rz};
  m.lengths = {Coordinate::xyz, Coordinate::rxyz};
  m.frame = dice.chance(0.5) ? CoordinateFrame::tip : CoordinateFrame::base;
  if (dice.chance(0.3))
    m.sources.push_back({.owner = 0, .mean = 1e-4, .half_width = 2e-4, .sigma = 1e-4, .sigma_ratios = {3}});
  if (dice.chance(0.3))
    m.sources.push_back(testing::in_parent_link({.where = IndependentError::Where::origin,
                                                 .link = dice.below(m.chain.joints.size()),
                                                 .direction = dice.direction(),
                                                 .mean = 1e-5,
                                                 .half_width = 2e-4,
                                                 .sigma = 1e-4,
                                                 .sigma_ratios = {5}},
                                                m.chain));
  return m;
}

Eigen::VectorXd configuration_in(Dice& dice, const std::vector<Limits>& ranges) {
  Eigen::VectorXd q(static_cast<Eigen::Index>(ranges.size()));
  for (std::size_t j = 0; j < ranges.size(); ++j)  // the ends of the ranges often
    q[static_cast<Eigen::Index>(j)] = dice.chance(0.2)   ? ranges[j].lower
                                      : dice.chance(0.2) ? ranges[j].upper
                                                         : dice.between(ranges[j].lower, ranges[j].upper);
  return q;
}

std::vector<Figure> all_figures(std::size_t coordinates, std::ptrdiff_t filter) {
  std::vector<Figure> figures;
  for (std::size_t c = 0; c < coordinates; ++c)
    for (const Bound bound : {Bound::worst_case, Bound::sigma}) figures.push_back({c, filter, bound});
  return figures;
}

OperationalModel planar(double first, double second, double first_step, double second_step) {
  OperationalModel m;
  m.chain.base = "base", m.chain.tip = "tip";
  m.chain.joints.resize(2);
  for (std::size_t k = 0; k < 2; ++k) {
    m.chain.joints[k].name = k ? "elbow" : "shoulder";
    m.chain.joints[k].coordinate = k;
    m.chain.independent.push_back({m.chain.joints[k].name, JointType::revolute, {}, true});
  }
  m.chain.joints[1].origin.translation().x() = first;
  m.chain.tip_offset.translation().x() = second;
  m.transmission = {{{first_step}, {second_step}}, Eigen::MatrixXd::Identity(2, 2)};
  m.coordinates = {Coordinate::x, Coordinate::y, Coordinate::z, Coordinate::rz};
  m.lengths = {Coordinate::xyz};
  return m;
}

TEST(ProvenMaximum, OfAPlanarArmIsThatOfTheStretchedArm) {
  const OperationalModel m = planar(0.4, 0.3, 2e-3, 1e-3);
  const std::vector<Limits> whole(
      2, Limits{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()});
  const auto proven = proven_maxima(m, {}, whole,
                                    {{0, -1, Bound::worst_case},
                                     {0, -1, Bound::sigma},
                                     {4, -1, Bound::worst_case},
                                     {4, -1, Bound::sigma},
                                     {3, -1, Bound::worst_case}},
                                    {.gap = 1e-3});
  const double worst = 0.5 * (2e-3 * 0.7 + 1e-3 * 0.3),
               sigma = std::hypot(2e-3 * 0.7, 1e-3 * 0.3) / std::sqrt(12.0);
  const double expected[] = {worst, sigma, worst, sigma, 1.5e-3};
  for (std::size_t i = 0; i < proven.size(); ++i) {
    EXPECT_NEAR(proven[i].lower, expected[i], 1e-12 * expected[i]) << i;
    EXPECT_GE(proven[i].upper, expected[i]) << i;
    EXPECT_LE(proven[i].gap(), 1e-3) << i;
  }
}

/// A proof ends at a tenth of the distance to a limit, on either side, and its bound holds.
TEST(ProvenMaximum, OfAFarLimitIsAsWideAsTheDistanceAllows) {
  const OperationalModel m = planar(0.4, 0.3, 2e-3, 1e-3);
  const std::vector<Limits> whole(2, Limits{-3, 3});
  const double sigma = std::hypot(2e-3 * 0.7, 1e-3 * 0.3) / std::sqrt(12.0);
  const auto proven = [&](double limit) {
    return proven_maxima(m, {}, whole, {{0, -1, Bound::sigma}},
                         {.gap = 1e-3, .limits = {limit}, .of_distance = 0.1})[0];
  };
  for (const double limit : {6 * sigma, sigma / 6}) {
    EXPECT_NEAR(proven(limit).wanted_gap, 0.5, 1e-9);
    EXPECT_LE(proven(limit).gap(), 0.5);
    EXPECT_GE(proven(limit).upper, sigma);
  }
  EXPECT_EQ(proven(1.005 * sigma).wanted_gap, 1e-3);
  EXPECT_EQ(proven(1e9 * sigma).wanted_gap, 1);
}

TEST(ProvenMaximum, IsReachedWhereItSaysAndNeverExceeded) {
  const std::vector<Norms> filters{norms(difference_filter(1000, 1))};
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    Dice dice(100 + seed);
    const OperationalModel m = random_model(dice, 1 + dice.below(4));
    const std::vector<Limits> ranges = random_ranges(dice, m.chain);
    std::vector<Figure> figures = all_figures(8, -1);
    for (const Figure& figure : all_figures(8, 0)) figures.push_back(figure);
    for (std::size_t c = 0; c < 8; ++c) figures.push_back({c, -1, Bound::worst_case_rigorous});
    const auto proven = proven_maxima(m, filters, ranges, figures, {.gap = 0.05});
    FigureValues values(m, filters, {});
    std::vector<Eigen::VectorXd> points;
    for (int i = 0; i < 4000; ++i) points.push_back(configuration_in(dice, ranges));
    const auto there = values(figures, points);
    for (std::size_t f = 0; f < figures.size(); ++f) {
      const double sampled = *std::max_element(there[f].begin(), there[f].end());
      EXPECT_LE(sampled, proven[f].upper) << seed << ' ' << f;
      EXPECT_LE(sampled, proven[f].lower * (1 + 1e-6) + 1e-18) << "a poor search: " << seed << ' ' << f;
      EXPECT_EQ(values({figures[f]}, {proven[f].at})[0][0], proven[f].lower);
      EXPECT_LE(proven[f].lower, proven[f].upper);
      for (std::size_t j = 0; j < ranges.size(); ++j) {
        EXPECT_GE(proven[f].at[static_cast<Eigen::Index>(j)], ranges[j].lower);
        EXPECT_LE(proven[f].at[static_cast<Eigen::Index>(j)], ranges[j].upper);
      }
    }
  }
}

TEST(ProvenMaximum, BehindAFilterIsThatOfItsModel) {
  const std::vector<Norms> filters{norms(difference_filter(1000, 2)),
                                   norms(design_filter("butterworth", 1, 1000, 3, 40))};
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Dice dice(seed);
    OperationalModel m = random_model(dice, 4);
    for (IndependentError& s : m.sources) s.sigma_ratios = {2, 3};
    const Eigen::VectorXd q = configuration_in(dice, random_ranges(dice, m.chain));
    const OperationalError e = operational_error(m, q);
    for (std::size_t f = 0; f < filters.size(); ++f) {
      const Eigen::VectorXd ratios = sigma_ratios(m.sources, f, filters[f].h2);
      for (Eigen::Index c = 0; c < 6; ++c) {
        const Bounds expected = derivative_error(e, c, filters[f], ratios);
        const Figure worst{static_cast<std::size_t>(c), static_cast<std::ptrdiff_t>(f), Bound::worst_case};
        Figure sigma = worst;
        sigma.bound = Bound::sigma;
        EXPECT_NEAR(operational_error(figure_model(m, filters, {}, worst), q).worst_case[c],
                    expected.worst_case, 1e-12 * expected.worst_case);
        EXPECT_NEAR(operational_error(figure_model(m, filters, {}, sigma), q).sigma[c], expected.sigma,
                    1e-12 * expected.sigma);
      }
    }
  }
}

TEST(ProvenMaximum, IsNotContradictedInSilence) {
  ProvenMaximum proven{1, 2, {}};
  set_reached(proven, 2 * (1 + 1e-13));  // rounding
  EXPECT_EQ(proven.lower, proven.upper);
  EXPECT_EQ(proven.gap(), 0);
  EXPECT_THROW(set_reached(proven, 2.1), std::logic_error);
}

TEST(ProvenMaximum, DoesNotDependOnThreads) {
  Dice dice(3);
  const OperationalModel m = random_model(dice, 4);
  const std::vector<Limits> ranges = random_ranges(dice, m.chain);
  const auto one = proven_maxima(m, {}, ranges, all_figures(6, -1), {.gap = 0.05, .threads = 1});
  const auto three = proven_maxima(m, {}, ranges, all_figures(6, -1), {.gap = 0.05, .threads = 3});
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].lower, three[i].lower);
    EXPECT_EQ(one[i].upper, three[i].upper);
    EXPECT_EQ(one[i].at, three[i].at);
  }
}

TEST(ProvenMaximum, StartsFromConfigurationsThatAreGiven) {
  Dice dice(11);
  const OperationalModel m = random_model(dice, 4);
  const std::vector<Limits> ranges = random_ranges(dice, m.chain);
  FigureValues values(m, {}, {});
  const Figure figure{0, -1, Bound::worst_case};
  const Eigen::VectorXd start = configuration_in(dice, ranges);
  EXPECT_GE(proven_maxima(m, {}, ranges, {figure}, {.gap = 0.5, .starts = {start}})[0].lower,
            values({figure}, {start})[0][0]);
}

TEST(ProvenMaximum, HasAGapRelativeToItsLowerBound) {
  EXPECT_DOUBLE_EQ((ProvenMaximum{2, 3, {}}.gap()), 0.5);
  EXPECT_EQ((ProvenMaximum{0, 0, {}}.gap()), 0);
  EXPECT_TRUE(std::isinf(ProvenMaximum{0, 3, {}}.gap()));
}

TEST(ProvenMaximum, OfEulerAnglesHasNoUpperBound) {
  OperationalModel m = planar(0.4, 0.3, 2e-3, 1e-3);
  m.coordinates = {Coordinate::yaw};
  m.lengths = {};
  const auto proven = proven_maxima(m, {}, {{-1, 1}, {-1, 1}}, {{0, -1, Bound::worst_case}});
  EXPECT_NEAR(proven[0].lower, 1.5e-3, 1e-15);
  EXPECT_TRUE(std::isinf(proven[0].upper));
  EXPECT_TRUE(std::isinf(proven[0].gap()));
}

TEST(ProvenMaximum, OfSigmaWithAnUnknownSpectrumIsAnError) {
  OperationalModel m = planar(0.4, 0.3, 2e-3, 1e-3);
  m.transmission.encoders[0].accuracy = 1e-3;
  const std::vector<SigmaRatios> unknown(2, {{std::numeric_limits<double>::quiet_NaN()}, {}});
  m.sources = accuracy_sources(m.transmission.encoders, unknown, unknown);
  const std::vector<Norms> filters{norms(difference_filter(1000, 1))};
  EXPECT_THROW(proven_maxima(m, filters, {{-1, 1}, {-1, 1}}, {{0, 0, Bound::sigma}}), Error);
  EXPECT_NO_THROW(proven_maxima(m, filters, {{-1, 1}, {-1, 1}}, {{0, 0, Bound::worst_case}}));
}

TEST(ProvenMaximum, OfAnEndlessJointWithACrookedMimicNeedsLimits) {
  OperationalModel m = planar(0.4, 0.3, 2e-3, 1e-3);
  m.chain.joints[1].coordinate = 0;
  m.chain.joints[1].multiplier = 0.3;
  m.chain.independent.pop_back();
  m.transmission = {{{1e-3}}, Eigen::MatrixXd::Identity(1, 1)};
  constexpr double infinity = std::numeric_limits<double>::infinity();
  EXPECT_THROW(proven_maxima(m, {}, {{-infinity, infinity}}, {{0, -1, Bound::sigma}}), Error);
  m.chain.joints[1].multiplier = -2;
  EXPECT_LE(proven_maxima(m, {}, {{-infinity, infinity}}, {{0, -1, Bound::sigma}})[0].gap(), 0.01);
}

}  // namespace
}  // namespace qerr
