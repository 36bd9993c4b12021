#include "qerr/kinematics/configurations.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <set>

namespace qerr {
namespace {

Configurations unit_cube(SamplingMethod method, std::size_t joints, std::uint64_t seed = 1) {
  Configurations c;
  c.method = method;
  c.seed = seed;
  c.ranges.assign(joints, Limits{0, 1});
  return c;
}

Configurations small_grid() {
  Configurations c = unit_cube(SamplingMethod::grid, 3);
  c.ranges = {{-1, 1}, {0, 4}, {5, 7}};
  c.count = 3;
  return c;
}

// The contract of draw: configuration i is equal in every block that contains it.
RC_GTEST_PROP(Configurations, DoNotDependOnCountOrBlocks, ()) {
  const auto method = *rc::gen::element(SamplingMethod::sobol, SamplingMethod::random);
  Configurations c =
      unit_cube(method, *rc::gen::inRange<std::size_t>(1, 31), *rc::gen::arbitrary<std::uint64_t>());
  const auto first = *rc::gen::inRange<std::uint64_t>(0, 5000);
  const auto count = *rc::gen::inRange<std::uint64_t>(1, 70);
  c.count = first + count;
  const Eigen::MatrixXd block = draw(c, first, count);
  const auto i = *rc::gen::inRange<std::uint64_t>(0, count);
  c.count = 1;
  RC_ASSERT(draw(c, first + i, 1).col(0) == block.col(static_cast<Eigen::Index>(i)));
}

TEST(Configurations, BlocksOfEveryMethodArePartsOfOneSequence) {
  Configurations list = unit_cube(SamplingMethod::list, 2);
  for (int i = 0; i < 12; ++i) list.points.push_back(Eigen::Vector2d(i, -i));
  for (const Configurations& c :
       {unit_cube(SamplingMethod::sobol, 7), unit_cube(SamplingMethod::random, 7), small_grid(), list}) {
    const Eigen::MatrixXd all = draw(c, 0, 12);
    for (std::uint64_t i = 0; i < 12; ++i)
      EXPECT_EQ(draw(c, i, 1).col(0), all.col(static_cast<Eigen::Index>(i))) << i;
    EXPECT_EQ(draw(c, 5, 7), all.rightCols(7));
  }
}

TEST(Configurations, SeedsGiveOtherPointsAndTheSameSeedTheSame) {
  for (const SamplingMethod method : {SamplingMethod::sobol, SamplingMethod::random}) {
    std::set<double> seen;
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
      const Eigen::MatrixXd q = draw(unit_cube(method, 3, seed), 0, 1);
      EXPECT_EQ(q, draw(unit_cube(method, 3, seed), 0, 1));
      for (const double value : q.reshaped()) seen.insert(value);
    }
    EXPECT_EQ(seen.size(), 600u);
  }
}

TEST(Configurations, StayInsideTheirRanges) {
  for (const SamplingMethod method : {SamplingMethod::sobol, SamplingMethod::random}) {
    Configurations c = unit_cube(method, 3);
    c.ranges = {{-2, -1}, {3, 3}, {0.1, std::nextafter(0.1, 1)}};
    const Eigen::MatrixXd q = draw(c, 0, 5000);
    for (Eigen::Index j = 0; j < 3; ++j) {
      EXPECT_GE(q.row(j).minCoeff(), c.ranges[static_cast<std::size_t>(j)].lower);
      EXPECT_LE(q.row(j).maxCoeff(), c.ranges[static_cast<std::size_t>(j)].upper);
    }
    EXPECT_LT(q.row(0).minCoeff(), -1.99) << "the range is used";
    EXPECT_GT(q.row(0).maxCoeff(), -1.01);
  }
}

TEST(Configurations, SobolHasOnePointOfEveryBlockInEveryDyadicInterval) {
  for (const std::uint64_t seed : {1u, 2u, 99u}) {
    const Eigen::MatrixXd q = draw(unit_cube(SamplingMethod::sobol, 10, seed), 0, 1024);
    for (Eigen::Index size = 1; size <= 1024; size *= 2)
      for (Eigen::Index start = 0; start < 1024; start += size)
        for (Eigen::Index j = 0; j < q.rows(); ++j) {
          std::set<Eigen::Index> cells;
          for (Eigen::Index i = start; i < start + size; ++i)
            cells.insert(static_cast<Eigen::Index>(q(j, i) * static_cast<double>(size)));
          ASSERT_EQ(cells.size(), static_cast<std::size_t>(size))
              << "seed " << seed << ", points " << start << " to " << start + size - 1 << ", dimension " << j;
        }
  }
}

TEST(Configurations, SobolMeansAreMoreAccurateThanRandomOnes) {
  // Mean of x_i x_j over the unit cube: 1/4. 4096 random points miss it by about 2e-3, Sobol points by far
  // less.
  const auto worst = [](SamplingMethod method) {
    const Eigen::MatrixXd q = draw(unit_cube(method, 7), 0, 4096);
    double miss = 0;
    for (Eigen::Index i = 0; i < 7; ++i) {
      miss = std::max(miss, std::abs(q.row(i).mean() - 0.5));
      for (Eigen::Index j = 0; j < i; ++j)
        miss = std::max(miss, std::abs(q.row(i).dot(q.row(j)) / 4096 - 0.25));
    }
    return miss;
  };
  EXPECT_LT(worst(SamplingMethod::sobol), 1e-3);
  EXPECT_LT(worst(SamplingMethod::random), 2e-2);
  EXPECT_GT(worst(SamplingMethod::random), 2e-3);
}

TEST(Configurations, GridIncludesBothEndsAndTheLastJointVariesFastest) {
  Configurations c = small_grid();
  ASSERT_EQ(size(c), 27u);
  Eigen::MatrixXd expected(3, 27);
  for (Eigen::Index i = 0; i < 27; ++i)
    expected.col(i) << static_cast<double>(i / 9) - 1, 2.0 * static_cast<double>(i / 3 % 3),
        5 + static_cast<double>(i % 3);
  EXPECT_EQ(draw(c, 0, 27), expected);
  c.ranges[0] = {0.1, 0.7};
  EXPECT_EQ(draw(c, 0, 1)(0, 0), 0.1);
  EXPECT_EQ(draw(c, 26, 1)(0, 0), 0.7);
  c.count = 1;
  ASSERT_EQ(size(c), 1u);
  EXPECT_EQ(draw(c, 0, 1).col(0), Eigen::Vector3d(0.4, 2, 6)) << "a single value is the middle";
}

TEST(Configurations, SizeIsTheCountAndSaturates) {
  Configurations c = unit_cube(SamplingMethod::sobol, 2);
  c.count = 123;
  EXPECT_EQ(size(c), 123u);
  c.method = SamplingMethod::list;
  EXPECT_EQ(size(c), 0u);
  c.points.assign(4, Eigen::Vector2d::Zero());
  EXPECT_EQ(size(c), 4u);
  constexpr std::uint64_t most = std::numeric_limits<std::int64_t>::max();
  const auto grid_size = [](std::size_t joints, std::uint64_t values) {
    Configurations grid = unit_cube(SamplingMethod::grid, joints);
    grid.count = values;
    return size(grid);
  };
  EXPECT_EQ(grid_size(62, 2), std::uint64_t{1} << 62);
  EXPECT_EQ(grid_size(63, 2), most);
  EXPECT_EQ(grid_size(40, 1000), most);
  EXPECT_EQ(grid_size(1, most), most);
}

/// FNV-1a over the bits of the first points.
std::uint64_t hash(const Eigen::MatrixXd& q) {
  std::uint64_t h = 0xCBF29CE484222325u;
  for (const double value : q.reshaped()) h = (h ^ std::bit_cast<std::uint64_t>(value)) * 0x100000001B3u;
  return h;
}

// Golden: SplitMix64's finalizer and Joe and Kuo's directions (new-joe-kuo-6) in Python's integers, exact.
// Point 0 of Sobol's sequence, the origin, is point 0 here too: without it the first 2^k points are not a
// net.
TEST(Configurations, FirstPointsAreReproducible) {
  using Rows = std::array<std::array<double, 3>, 5>;
  const Rows sobol{{{0x1.8c42fc136081ep-2, 0x1.1484cab5faac0p-5, 0x1.3952194cd69a8p-2},
                    {0x1.c6217e09b040fp-1, 0x1.11484cab5faacp-1, 0x1.9ca90ca66b4d4p-1},
                    {0x1.46217e09b040fp-1, 0x1.22909956bf558p-2, 0x1.ca90ca66b4d40p-5},
                    {0x1.1885f826c103cp-3, 0x1.91484cab5faacp-1, 0x1.1ca90ca66b4d4p-1},
                    {0x1.885f826c103c0p-7, 0x1.a2909956bf558p-2, 0x1.dca90ca66b4d4p-1}}};
  const Rows random{{{0x1.8c42fc136081ep-2, 0x1.1484cab5faac0p-5, 0x1.3952194cd69a8p-2},
                     {0x1.d7b6e42d49ffdp-1, 0x1.8bfacc8492f2ep-1, 0x1.acafa7cbdb905p-1},
                     {0x1.5471cce985870p-4, 0x1.2077d7a001253p-1, 0x1.6632730ba467cp-2},
                     {0x1.34fcb81717cc4p-1, 0x1.4af8c0f8fae00p-4, 0x1.d904ee0cbe671p-1},
                     {0x1.fe17c208d7510p-2, 0x1.c7a3fc877b960p-1, 0x1.d88f2aea57fc7p-1}}};
  for (const auto& [method, rows] :
       {std::pair{SamplingMethod::sobol, sobol}, {SamplingMethod::random, random}}) {
    const Eigen::MatrixXd q = draw(unit_cube(method, 3, 42), 0, 5);
    for (std::size_t i = 0; i < 5; ++i)
      for (std::size_t j = 0; j < 3; ++j)
        EXPECT_EQ(q(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(i)), rows[i][j])
            << (method == SamplingMethod::sobol ? "sobol " : "random ") << i << ' ' << j;
  }
}

TEST(Configurations, FirstThousandPointsAreReproducible) {
  EXPECT_EQ(hash(draw(unit_cube(SamplingMethod::sobol, 3, 42), 0, 1000)), 0x4192ea39ec1406bdu);
  EXPECT_EQ(hash(draw(unit_cube(SamplingMethod::random, 3, 42), 0, 1000)), 0x2e8eaf1c734e5784u);
}

}  // namespace
}  // namespace qerr
