#include "bound/proven/line_maximum.hpp"

#include <gtest/gtest.h>

#include <cmath>

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

}  // namespace
}  // namespace qerr
