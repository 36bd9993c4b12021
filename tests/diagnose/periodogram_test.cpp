#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "diagnose/search/linear_model.hpp"
#include "diagnose/search/peaks.hpp"
#include "support/random_chain.hpp"

namespace qerr {
namespace {

using testing::Dice;

double plain_power(const Eigen::ArrayXd& score, const Eigen::ArrayXd& argument, double rate) {
  std::complex<double> sum = 0;
  for (Eigen::Index k = 0; k < score.size(); ++k) sum += score[k] * std::polar(1.0, rate * argument[k]);
  return std::norm(sum);
}

TEST(Periodogram, HasThePowerOfEveryRate) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Dice dice(seed);
    const Eigen::Index rows = 10 + static_cast<Eigen::Index>(dice.below(3000));
    const Eigen::Index last = 8 + static_cast<Eigen::Index>(dice.below(2000));
    const double range = dice.between(0.01, 100), spacing = 0.5 * std::numbers::pi / range;
    Eigen::ArrayXd argument(rows), score(rows);
    for (Eigen::Index k = 0; k < rows; ++k)
      argument[k] = dice.between(0, range), score[k] = dice.between(-1, 1);
    argument[0] = 0, argument[1] = range;
    // A line, so that some power is large.
    const double rate = dice.between(4, static_cast<double>(last)) * spacing;
    for (Eigen::Index k = 0; k < rows; ++k) score[k] += std::cos(rate * argument[k]);
    const std::vector<float> powers = periodogram(score, argument, spacing, 4, last);
    ASSERT_EQ(static_cast<Eigen::Index>(powers.size()), last - 3);
    const double most = *std::max_element(powers.begin(), powers.end());
    for (Eigen::Index n = 4; n <= last; n += 1 + last / 50) {
      const double expected = plain_power(score, argument, static_cast<double>(n) * spacing);
      EXPECT_NEAR(powers[static_cast<std::size_t>(n - 4)], expected, 0.03 * most)
          << "seed " << seed << ", " << n;
      EXPECT_NEAR(power_at(score, argument, static_cast<double>(n) * spacing), expected, 1e-9 * most);
    }
  }
}

// Columns that are zero in whole blocks of rows, as a table in time has them, are left out of products there.
TEST(WeightedGram, IsThatOfAllRows) {
  Dice dice(3);
  const Eigen::Index count = 21;
  for (const Eigen::Index rows : {1, 7, 503, 504, 505, 1700}) {
    Eigen::MatrixXd z = Eigen::MatrixXd::Zero(rows, count + 2);
    for (Eigen::Index i = 0; i < count; ++i) {
      const Eigen::Index first = i < 4 ? 0 : 80 * i, last = i < 4 ? rows : std::min(rows, first + 300);
      for (Eigen::Index k = first; k < last; ++k) z(k, i) = dice.between(-1, 1);
    }
    Eigen::VectorXd weight(rows);
    for (Eigen::Index k = 0; k < rows; ++k) weight[k] = dice.between(0, 2), z(k, count) = dice.between(-1, 1);
    z.col(count + 1).setOnes();
    const Eigen::MatrixXd expected = z.transpose() * weight.asDiagonal() * z;
    EXPECT_LT((weighted_gram(z.leftCols(count), z.col(count), weight) - expected).cwiseAbs().maxCoeff(),
              1e-11 * static_cast<double>(rows))
        << rows;
  }
}

TEST(LinearModel, SearchesThatMeetEndTogether) {
  Dice dice(4);
  const Eigen::Index rows = 200, count = 6;
  Eigen::MatrixXd columns(rows, count);
  for (double& x : columns.reshaped()) x = dice.between(-1, 1);
  Eigen::VectorXd y = 2 * columns.col(1) - columns.col(4);
  for (double& x : y) x += dice.between(-0.1, 0.1);
  const LinearModel model(columns, y, Eigen::VectorXd::Ones(rows), 0);
  std::vector<ColumnGroup> groups;
  for (Eigen::Index i = 0; i < count; ++i)
    groups.push_back({.first = i, .count = 1, .family = static_cast<int>(i), .price = 5});
  std::vector<LinearModel::Set> seen;
  LinearModel::Set end = model.search(groups, {}, 0, rows, 1e-9, seen);
  std::sort(end.begin(), end.end());
  EXPECT_EQ(end, (LinearModel::Set{1, 4}));
  // From a set that the first search has passed, the second one goes no further; from any other, to its end.
  EXPECT_EQ(model.search(groups, {}, 0, rows, 1e-9, seen), LinearModel::Set{});
  LinearModel::Set other = model.search(groups, {0, 4}, 0, rows, 1e-9, seen);
  std::sort(other.begin(), other.end());
  EXPECT_EQ(other, end);
}

TEST(Bump, IsThatOfTheResidual) {
  const Eigen::ArrayXd place = Eigen::ArrayXd::LinSpaced(4000, -2, 3), weight = 2 + place.sin();
  const Bump b = strongest_bump((-0.5 * ((place - 0.7) / 0.1).square()).exp() - 0.1, weight, place);
  EXPECT_NEAR(b.position, 0.7, 0.002);
  EXPECT_NEAR(b.width, 0.1, 0.002);
}

TEST(Transitions, AreThoseOfTheResidual) {
  const Eigen::ArrayXd time = Eigen::ArrayXd::LinSpaced(5000, 0, 50), weight = 2 + time.sin();
  Event ramp{.time = 21};
  find_transitions(ramp, ((time - 20) / 3).max(0.0).min(1.0) - 0.4, weight, time);
  EXPECT_NEAR(ramp.ramp_start, 20, 0.02);
  EXPECT_NEAR(ramp.ramp_duration, 3, 0.02);
  Event approach{.time = 21};
  find_transitions(approach, 1 - (-(time - 20).max(0.0) / 4).exp(), weight, time);
  EXPECT_NEAR(approach.approach_start, 20, 0.02);
  EXPECT_NEAR(approach.time_constant, 4, 0.03);
}

}  // namespace
}  // namespace qerr
