#include <gtest/gtest.h>

#include <cmath>

#include "bound/signal_errors.hpp"
#include "support/random_chain.hpp"

namespace qerr {
namespace {

using testing::Dice;

/// All signs, one by one.
double by_enumeration(const Eigen::Vector3d& mean, const Eigen::Matrix3Xd& generators) {
  double largest = 0;
  for (unsigned long bits = 0; bits < 1ul << generators.cols(); ++bits) {
    Eigen::Vector3d corner = mean;
    for (Eigen::Index k = 0; k < generators.cols(); ++k)
      corner += (bits >> k & 1 ? 1 : -1) * generators.col(k);
    largest = std::max(largest, corner.norm());
  }
  return largest;
}

Eigen::Matrix3Xd random_generators(Dice& dice, Eigen::Index count) {
  Eigen::Matrix3Xd g(3, count);
  for (Eigen::Index k = 0; k < count; ++k) g.col(k) = dice.vector(3, -1, 1);
  return g;
}

TEST(LargestCorner, IsThatOfAllSigns) {
  Dice dice(3);
  for (int trial = 0; trial < 60; ++trial) {
    const Eigen::Matrix3Xd g = random_generators(dice, 1 + static_cast<Eigen::Index>(dice.below(15)));
    const Eigen::Vector3d mean =
        dice.chance(0.5) ? Eigen::Vector3d(dice.vector(3, -1, 1)) : Eigen::Vector3d(0, 0, 0);
    const double expected = by_enumeration(mean, g);
    EXPECT_NEAR(largest_corner(mean, g), expected, 1e-13 * expected) << g.cols();
  }
}

TEST(LargestCorner, HoldsForGeneratorsInAPlaneOnALineAndInGroups) {
  Dice dice(4);
  for (int trial = 0; trial < 60; ++trial) {
    Eigen::Matrix3Xd g = random_generators(dice, 13 + static_cast<Eigen::Index>(dice.below(3)));
    const std::size_t shape = dice.below(4);
    for (Eigen::Index k = 0; k < g.cols(); ++k) {
      if (shape == 0) g(2, k) = 0;                                          // a planar arm
      if (shape == 1) g.col(k) = g.col(0) * dice.between(-1, 1);            // on a line
      if (shape == 2 && k > 2) g.col(k) = g.col(k % 3) * (k % 2 ? -2 : 1);  // parallel in groups
      if (shape == 3 && k % 3 == 0) g.col(k).setZero();                     // without effect
    }
    const double expected = by_enumeration({0, 0, 0}, g);
    EXPECT_NEAR(largest_corner({0, 0, 0}, g), expected, 1e-13 * expected) << "shape " << shape;
  }
}

// Lengths of errors are far below one metre.
TEST(LargestCorner, IsProportionalToItsGenerators) {
  Dice dice(5);
  for (int trial = 0; trial < 40; ++trial) {
    Eigen::Matrix3Xd g = random_generators(dice, 11 + static_cast<Eigen::Index>(dice.below(4)));
    if (trial % 4 == 0) g.row(2).setZero();
    if (trial % 4 == 1) g = (g.col(0) * dice.vector(g.cols(), -1, 1).transpose()).eval();
    const Eigen::Vector3d mean = trial % 2 == 0 ? Eigen::Vector3d(0.1, -0.2, 0.3) : Eigen::Vector3d(0, 0, 0);
    const double scale = std::exp2(-20), whole = largest_corner(mean, g);
    EXPECT_NEAR(largest_corner(scale * mean, scale * g), scale * whole, 1e-14 * scale * whole) << trial;
  }
}

TEST(LargestCorner, OfNoGeneratorsIsTheMean) {
  EXPECT_DOUBLE_EQ(largest_corner({3, 0, -4}, Eigen::Matrix3Xd(3, 0)), 5);
}

}  // namespace
}  // namespace qerr
