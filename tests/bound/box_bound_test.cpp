#include "bound/proven/box_bound.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "bound/proven/ascent.hpp"
#include "support/random_model.hpp"

namespace qerr {
namespace {

using testing::ChainMix;
using testing::Dice;

OperationalModel random_model(Dice& dice) {
  ChainMix mix{1 + dice.below(5)};
  mix.square = dice.chance(0.5) ? 0.7 : 0;
  OperationalModel m{make_chain(testing::random_robot(dice, mix), "", ""), {}, {}};
  m.transmission = testing::random_transmission(dice, m.chain, 1e-4, 1e-3, dice.chance(0.5));
  m.coordinates = {Coordinate::x,  Coordinate::y,  Coordinate::z,
                   Coordinate::rx, Coordinate::ry, Coordinate::rz};
  m.lengths = {Coordinate::xyz, Coordinate::rxyz};
  m.frame = dice.chance(0.5) ? CoordinateFrame::tip : CoordinateFrame::base;
  for (int i = 0; i < 2; ++i)
    if (dice.chance(0.4)) m.sources.push_back(testing::displaced_origin(dice, m.chain));
  return m;
}

TEST(ErrorTerms, AreTheFiguresOfTheModel) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    Dice dice(seed);
    const OperationalModel m = random_model(dice);
    const Eigen::VectorXd q = dice.vector(static_cast<Eigen::Index>(m.chain.independent.size()), -3, 3);
    const OperationalError e = operational_error(m, q);
    for (Eigen::Index c = 0; c < 6; ++c) {
      const auto index = static_cast<std::size_t>(c);
      const double scale = e.worst_case.maxCoeff();
      EXPECT_NEAR(ErrorTerms(m, index, false).value(q), e.worst_case[c], 1e-13 * scale) << seed << ' ' << c;
      EXPECT_NEAR(ErrorTerms(m, index, true).value(q), e.sigma[c], 1e-13 * scale) << seed << ' ' << c;
    }
    EXPECT_NEAR(ErrorTerms(m, 6, true).value(q), e.sigma.head<3>().norm(), 1e-13);
    EXPECT_NEAR(ErrorTerms(m, 7, true).value(q), e.sigma.tail<3>().norm(), 1e-13);
  }
}

TEST(ErrorTerms, AlongAnyDirectionReachTheLength) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Dice dice(seed);
    const OperationalModel m = random_model(dice);
    const auto n = static_cast<Eigen::Index>(m.chain.independent.size());
    const ErrorTerms length(m, 6, false);
    const ErrorTerms along = length.along_any_direction(m.chain.independent.size());
    Eigen::VectorXd q = dice.vector(n + 2, -3, 3);
    double largest = 0;
    for (q[n] = -1.6; q[n] < 1.6; q[n] += 0.05)
      for (q[n + 1] = -1.6; q[n + 1] < 1.6; q[n + 1] += 0.05) largest = std::max(largest, along.value(q));
    const double expected = length.value(Eigen::VectorXd(q.head(n)));
    EXPECT_LE(largest, expected * (1 + 1e-12));
    EXPECT_GE(largest, expected * 0.998);
  }
}

/// Of boxes of any size, at their corners and within.
TEST(BoxBound, HoldsEverywhereInTheBox) {
  for (std::uint64_t seed = 0; seed < 150; ++seed) {
    Dice dice(seed);
    const OperationalModel m = random_model(dice);
    const std::size_t n = m.chain.independent.size();
    const std::vector<Limits> ranges(n, Limits{-3, 3});
    for (std::size_t c = 0; c < 8; ++c)
      for (const bool sigma : {false, true}) {
        ErrorTerms terms(m, c, sigma);
        std::vector<Limits> all = ranges;
        if (terms.length() && !sigma) {
          terms = terms.along_any_direction(n);
          all.insert(all.end(), 2, {-1.6, 1.6});
        }
        BoxBound bound(terms, all);
        const auto size = static_cast<Eigen::Index>(all.size());
        const double width = std::pow(10, dice.between(-6, 0));
        Eigen::VectorXd center = dice.vector(size, -1.5, 1.5), half = width * dice.vector(size, 0, 1);
        for (Eigen::Index j = 0; j < size; ++j)
          if (!bound.matters(static_cast<std::size_t>(j))) half[j] = 0;
        const BoxBound::Result result = bound(center, half);
        EXPECT_NEAR(result.at_center, terms.value(center), 1e-18);
        for (int i = 0; i < 40; ++i) {
          Eigen::VectorXd q = center;
          for (Eigen::Index j = 0; j < size; ++j) {
            const double part = dice.chance(0.5) ? (dice.chance(0.5) ? 1 : -1) : dice.between(-1, 1);
            // A joint without influence may be anywhere; of a length along one direction, with all
            // directions.
            const bool free = !bound.matters(static_cast<std::size_t>(j)) && !terms.turned_base();
            q[j] = free ? dice.between(-3, 3) : center[j] + part * half[j];
          }
          ASSERT_LE(terms.value(q), result.upper) << seed << ' ' << c << ' ' << sigma << ' ' << width;
        }
      }
  }
}

/// At a maximum inside the ranges the bound exceeds the figure by the third order of the box, where no term
/// changes its sign: halving the box divides the excess by 8, and by more than 4.
TEST(BoxBound, IsOfThirdOrderAtASmoothMaximum) {
  int smooth = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Dice dice(1000 + seed);
    OperationalModel m = random_model(dice);
    const std::size_t n = m.chain.independent.size();
    const std::vector<Limits> ranges(n, Limits{-4, 4});
    const ErrorTerms terms(m, dice.below(6), false);
    const Eigen::VectorXd top = ascend(terms, ranges, dice.vector(static_cast<Eigen::Index>(n), -1, 1));
    const Eigen::Matrix3Xd v = terms.vectors(terms.columns(top));
    bool usual = top.cwiseAbs().maxCoeff() < 3.9;
    for (Eigen::Index g = 0; g < v.cols(); ++g)
      usual = usual &&
              std::abs(v(terms.row(), g)) > 0.1 * terms.terms()[static_cast<std::size_t>(g)].weights.norm();
    if (!usual) continue;
    BoxBound bound(terms, ranges);
    const auto excess = [&](double width) {
      Eigen::VectorXd half = Eigen::VectorXd::Constant(static_cast<Eigen::Index>(n), width);
      for (std::size_t j = 0; j < n; ++j)
        if (!bound.matters(j)) half[static_cast<Eigen::Index>(j)] = 0;
      return bound(top, half).upper - terms.value(top);
    };
    if (!(excess(0.005) > 1e-10 * terms.value(top))) continue;
    ++smooth;
    EXPECT_GT(excess(0.01), 4.1 * excess(0.005)) << seed;
  }
  EXPECT_GE(smooth, 5);
}

TEST(BranchAndBound, ClosesTheGapOfShortChains) {
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    Dice dice(seed);
    OperationalModel m{make_chain(testing::random_robot(dice, ChainMix{3}), "", ""), {}, {}};
    m.transmission = testing::random_transmission(dice, m.chain, 1e-4, 1e-3, true);
    m.coordinates = {Coordinate::x, Coordinate::y, Coordinate::z};
    const std::vector<Limits> ranges(m.chain.independent.size(), Limits{-3, 2});
    for (const bool sigma : {false, true}) {
      const ErrorTerms terms(m, 1, sigma);
      double lower = 0;
      for (int i = 0; i < 20; ++i)
        lower = std::max(
            lower,
            terms.value(ascend(terms, ranges, dice.vector(static_cast<Eigen::Index>(ranges.size()), -3, 2))));
      const double upper = branch_and_bound(terms, ranges, lower, 0.01, boxes_of_gap(0.01)).upper;
      EXPECT_GE(upper, lower);
      EXPECT_LE(upper, lower * 1.01) << seed << ' ' << sigma;
    }
  }
}

TEST(BranchAndBound, TakesMoreBoxesForASmallerGap) {
  EXPECT_EQ(boxes_of_gap(0.01), 131072u);
  EXPECT_EQ(boxes_of_gap(0.005), 262144u);
  EXPECT_EQ(boxes_of_gap(1e-9), 2097152u);
}

}  // namespace
}  // namespace qerr
