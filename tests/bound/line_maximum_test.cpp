#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bound/proven/ascent.hpp"
#include "bound/proven/recursion.hpp"
#include "support/random_chain.hpp"

namespace qerr {
namespace {

using testing::Dice;

Harmonics random_harmonics(Dice& dice) {
  Harmonics h(static_cast<Eigen::Index>(1 + dice.below(7)), 3);
  for (Eigen::Index g = 0; g < h.rows(); ++g) h.row(g) = dice.vector(3, -1, 1).transpose();
  return h;
}

Limits random_range(Dice& dice) {
  const double lower = dice.between(-9, 4);
  return {lower, lower + dice.between(0, 8)};
}

Eigen::VectorXd values(const Harmonics& h, double t) {
  return h * Eigen::Vector3d(1, std::cos(t), std::sin(t));
}

TEST(LineMaximum, HarmonicsAreReadFromThreeAngles) {
  Dice dice(1);
  const double third = 2 * std::acos(-1.0) / 3;
  for (int i = 0; i < 20; ++i) {
    const Harmonics h = random_harmonics(dice);
    EXPECT_LT((harmonics(values(h, 0), values(h, third), values(h, -third)) - h).cwiseAbs().maxCoeff(),
              1e-14);
  }
}

TEST(LineMaximum, IsNotBelowAnySample) {
  Dice dice(2);
  for (int i = 0; i < 200; ++i) {
    const Harmonics h = random_harmonics(dice);
    const Limits range = random_range(dice);
    const auto magnitudes = [&](double t) { return values(h, t).cwiseAbs().sum(); };
    const auto squares = [&](double t) { return values(h, t).squaredNorm(); };
    const double of_magnitudes = argmax_of_magnitudes(h, range), of_squares = argmax_of_squares(h, range);
    for (const double t : {of_magnitudes, of_squares}) {
      EXPECT_GE(t, range.lower);
      EXPECT_LE(t, range.upper);
    }
    for (int k = 0; k <= 500; ++k) {
      const double t = range.lower + (range.upper - range.lower) * k / 500;
      EXPECT_GE(magnitudes(of_magnitudes), magnitudes(t) * (1 - 1e-13));
      EXPECT_GE(squares(of_squares), squares(t) * (1 - 1e-13));
    }
    EXPECT_NEAR(squares(argmax_by_search(squares, range, 64)), squares(of_squares),
                1e-6 * squares(of_squares));
  }
}

// A cell has side `step`: its corners are at most sqrt(2) steps outside the disc that it meets. 2e-6 of the
// reach are left for the rounding of positions in floats.
TEST(MomentDisc, HasTheCornersOfAllCellsThatMeetTheDiscAndNoFartherNodes) {
  for (const int nodes : {3, 5, 17, 65}) {
    const MomentDisc d = moment_disc(0.7, nodes);
    const auto distance = [&](int a, int b) { return std::hypot(d.at(a), d.at(b)); };
    double farthest = 0;
    for (int a = 0; a < nodes; ++a)
      for (int b = 0; b < nodes; ++b) {
        const auto row = static_cast<std::size_t>(a);
        const bool filled = d.begin[row] <= b && b < d.end[row];
        if (filled) farthest = std::max(farthest, distance(a, b));
        // The corner of a cell that is nearest to the middle of the grid is within the disc.
        const int inner_a = a + (2 * a < nodes - 1) - (2 * a > nodes - 1);
        const int inner_b = b + (2 * b < nodes - 1) - (2 * b > nodes - 1);
        EXPECT_TRUE(filled || distance(inner_a, inner_b) > d.radius) << nodes << ' ' << a << ' ' << b;
      }
    EXPECT_LE(farthest, (d.radius + std::sqrt(2.0) * d.step) * (1 + 2e-6)) << nodes;
    EXPECT_GE(d.at(nodes - 1), d.radius) << "the grid covers the disc";
    EXPECT_EQ(d.at((nodes - 1) / 2), 0);
  }
}

}  // namespace
}  // namespace qerr
