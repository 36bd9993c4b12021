#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bound/batched_error.hpp"
#include "qerr/filter/family.hpp"
#include "support/random_model.hpp"

namespace qerr {
namespace {

using testing::all_coordinates;
using testing::Dice;

/// Encoders that act on a moving joint, at the independent joint that it follows.
std::vector<Eigen::Index> encoders_of(const OperationalModel& m, const ChainJoint& joint) {
  std::vector<Eigen::Index> found;
  for (Eigen::Index j = 0; j < static_cast<Eigen::Index>(m.transmission.encoders.size()); ++j)
    if (joint.multiplier * m.transmission.coupling(static_cast<Eigen::Index>(joint.coordinate), j) != 0)
      found.push_back(j);
  return found;
}

/// Whether each moving joint has one encoder, and each encoder one joint.
bool one_to_one(const OperationalModel& m) {
  std::vector<Eigen::Index> taken;
  for (const ChainJoint& joint : m.chain.joints) {
    const std::vector<Eigen::Index> own = encoders_of(m, joint);
    if (own.size() != 1) return false;
    taken.push_back(own[0]);
  }
  std::sort(taken.begin(), taken.end());
  return std::adjacent_find(taken.begin(), taken.end()) == taken.end() &&
         taken.size() == m.transmission.encoders.size();
}

bool leads(const OperationalModel& m) {
  const std::vector<Coordinate> six(all_coordinates, all_coordinates + 6),
      three(six.begin(), six.begin() + 3);
  return m.frame == CoordinateFrame::base && (m.coordinates == three || m.coordinates == six);
}

TEST(ErrorPlan, IsTheQuickOneExactlyForOneEncoderAJoint) {
  int quick = 0, shared = 0, slow = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    Dice dice(seed);
    const OperationalModel m = testing::random_model(dice, 0, 0.3);
    const PlannedError planned(m, {});
    const ErrorPlan& p = planned.plan();
    const bool unbiased = m.sources.empty() && mean_errors(m.transmission).isZero(0);
    EXPECT_EQ(p.plain, unbiased) << seed;
    EXPECT_EQ(p.positions_first, leads(m)) << seed;
    ASSERT_EQ(p.direct, unbiased && leads(m) && one_to_one(m)) << seed;
    EXPECT_EQ(p.encoders, m.transmission.encoders.size()) << seed;
    EXPECT_EQ(p.parts, p.encoders + m.sources.size()) << seed;
    EXPECT_EQ(p.coordinates, m.coordinates.size()) << seed;
    if (!p.direct) {
      ++slow;
      EXPECT_NE(p.column_scale, nullptr) << seed;
      EXPECT_EQ(p.moving_parts, p.parts) << seed;
      continue;
    }
    ++quick;
    // sigma of the joint, by the definition Delta/sqrt(12), up to the sign.
    const Eigen::VectorXd sigma = resolutions(m.transmission) / std::sqrt(12.0);
    std::vector<double> scales;
    for (const ChainJoint& joint : m.chain.joints) {
      const Eigen::Index j = encoders_of(m, joint)[0];
      scales.push_back(std::abs(joint.multiplier *
                                m.transmission.coupling(static_cast<Eigen::Index>(joint.coordinate), j)) *
                       sigma[j]);
    }
    const bool equal =
        std::count(scales.begin(), scales.end(), scales[0]) == static_cast<std::ptrdiff_t>(scales.size());
    ASSERT_EQ(p.column_scale == nullptr, equal) << seed;
    shared += equal;
    for (std::size_t k = 0; k < scales.size(); ++k) {
      ASSERT_EQ(p.part[k].end - p.part[k].begin, 1) << seed;
      EXPECT_EQ(p.part[k].begin->joint, k) << seed;
      EXPECT_EQ(static_cast<Eigen::Index>(p.part[k].owner), encoders_of(m, m.chain.joints[k])[0]) << seed;
      EXPECT_NEAR(std::abs(p.part[k].begin->weight), scales[k], 1e-15 * scales[k]) << seed;
      if (!equal) {
        EXPECT_NEAR(std::abs(p.column_scale[k]), scales[k], 1e-15 * scales[k]) << seed;
      }
    }
  }
  EXPECT_GT(quick, 60);
  EXPECT_GT(shared, 20);
  EXPECT_GT(slow, 100);
}

TEST(ErrorPlan, ScalesErrorsByTheirLargestFigure) {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    Dice dice(500 + seed);
    OperationalModel m = testing::random_model(dice, 1, 0.3);
    m.coordinates = {Coordinate::x, Coordinate::rz};
    m.sources = {testing::random_source(dice, m.chain, 1), testing::displaced_origin(dice, m.chain)};
    const PlannedError planned(m, {.filters = {norms(difference_filter(1000, 1))}});
    const ErrorPlan& p = planned.plan();
    EXPECT_FALSE(p.plain || p.direct) << seed;
    EXPECT_TRUE(p.filtered_worst && p.filtered_sigma && p.quantization_parts) << seed;
    for (std::size_t i = 0; i < m.sources.size(); ++i) {
      const IndependentError& s = m.sources[i];
      const ErrorPart& part = p.part[p.encoders + i];
      const double largest = std::max({s.sigma, s.half_width, std::abs(s.mean)});
      const double scale = largest > 0 ? largest : 1;
      EXPECT_TRUE(part.source) << seed;
      EXPECT_EQ(part.owner, s.owner) << seed;
      EXPECT_DOUBLE_EQ(part.sigma * scale, s.sigma) << seed;
      EXPECT_DOUBLE_EQ(part.half_width * scale, s.half_width) << seed;
      EXPECT_DOUBLE_EQ(part.mean * scale, s.mean) << seed;
      EXPECT_DOUBLE_EQ(part.width * scale, std::abs(s.mean) + s.half_width) << seed;
      EXPECT_LE(std::max({part.sigma, part.half_width, std::abs(part.mean)}), 1) << seed;
      if (s.where == IndependentError::Where::origin) {
        EXPECT_NEAR(Eigen::Vector3d(part.direction).norm(), scale, 1e-15 * scale) << seed;
      }
      if (!s.sigma_ratios.empty()) {
        const double squared = std::pow(part.sigma * s.sigma_ratios[0], 2);
        EXPECT_NEAR(p.ratio_squares[p.encoders + i], squared, 1e-14 * squared) << seed;
      }
    }
  }
}

/// A tip on the axis of the last joint does not move with it; a tip beside it does.
TEST(ErrorPlan, LeavesOutAJointThatDoesNotMoveTheTip) {
  for (const double beside : {0.0, 0.1}) {
    OperationalModel m;
    m.chain.joints.resize(2);
    m.chain.independent.resize(2);
    m.chain.joints[1].origin.translation().x() = 0.4;
    m.chain.joints[1].axis = Eigen::Vector3d::UnitX();
    m.chain.joints[1].coordinate = 1;
    m.chain.tip_offset.translation() << 0.2, beside, 0;
    m.transmission = {{{1e-3}, {1e-3}}, Eigen::MatrixXd::Identity(2, 2)};
    m.coordinates = {Coordinate::x, Coordinate::y, Coordinate::z};
    const PlannedError planned(m, {});
    EXPECT_TRUE(planned.plan().direct);
    EXPECT_EQ(planned.plan().moving_parts, beside > 0 ? 2U : 1U);
  }
}

}  // namespace
}  // namespace qerr
