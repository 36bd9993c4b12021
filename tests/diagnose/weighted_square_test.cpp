#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "diagnose/inference/explanation.hpp"
#include "support/random_chain.hpp"

namespace qerr {
namespace {

using testing::Dice;

void expect_plain_product(const Eigen::MatrixXd& columns, const Eigen::ArrayXd& weight) {
  const Eigen::MatrixXd plain = columns.transpose() * weight.matrix().asDiagonal() * columns;
  EXPECT_LT((weighted_square(columns, weight) - plain).cwiseAbs().maxCoeff(),
            1e-13 * (1 + plain.cwiseAbs().maxCoeff()));
}

TEST(WeightedSquare, EqualsThePlainProductForColumnsOfAnyKind) {
  Dice dice(51);
  for (const Eigen::Index rows : {1, 30, 63, 64, 65, 1000})
    for (const Eigen::Index count : {1, 8, 9, 40}) {
      Eigen::MatrixXd columns(rows, count);
      for (Eigen::Index c = 0; c < count; ++c) {
        // Dense columns, knots of a table, sparse columns, and a column of zeros.
        const double centre = dice.between(0, 1), present = dice.between(0, 1);
        for (Eigen::Index k = 0; k < rows; ++k) {
          const double place = std::sin(3.0 * static_cast<double>(k) / static_cast<double>(rows)) - centre;
          columns(k, c) = c % 4 == 0   ? dice.between(-1, 1)
                          : c % 4 == 1 ? std::max(0.0, 1 - 20 * std::abs(place))
                          : c % 4 == 2 ? (dice.chance(0.1 * present) ? 1.0 : 0.0)
                                       : 0.0;
        }
      }
      const Eigen::ArrayXd weight =
          Eigen::ArrayXd::NullaryExpr(rows, [&](Eigen::Index) { return dice.between(0, 2); });
      expect_plain_product(columns, weight);
    }
}

}  // namespace
}  // namespace qerr
