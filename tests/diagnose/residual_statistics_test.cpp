#include <gtest/gtest.h>

#include <algorithm>

#include "support/design_filter.hpp"
#include "support/random_evidence.hpp"
#include "support/reference_residuals.hpp"

/// The kernels of the surrogates of a record against plain code, row by row.
namespace qerr {
namespace {

using testing::Dice;
using testing::EvidenceMix;

constexpr double agreement = 1e-12;

std::vector<Filter> velocity_filters() {
  std::vector<Filter> all{cascade(1, 1), cascade(1, 3), design_filter("butterworth", 1, 1000, 4, 100),
                          design_filter("first_order", 1, 1000, 2, 50)};
  all.push_back({{}, 2, 1000, 1, {0.5, 0.1, -0.3, -0.3}});  // by taps alone
  return all;
}

void expect_reference(const Evidence& e, Eigen::Index surrogates, InstructionSet set) {
  const std::vector<Filter> filters = velocity_filters();
  const auto ours = residual_statistics(e, filters, surrogates, 7, 1, set);
  const auto theirs = testing::reference_statistics(e, filters, surrogates, 7);
  ASSERT_EQ(ours.size(), theirs.size());
  for (std::size_t i = 0; i < ours.size(); ++i) {
    SCOPED_TRACE(ours[i].name);
    EXPECT_EQ(ours[i].name, theirs[i].name);
    EXPECT_EQ(ours[i].tail, theirs[i].tail);
    EXPECT_EQ(ours[i].degrees, theirs[i].degrees);
    EXPECT_EQ(ours[i].least, theirs[i].least);
    ASSERT_EQ(ours[i].values.size(), surrogates + 1);
    EXPECT_LT((ours[i].values - theirs[i].values).abs().maxCoeff(),
              agreement * std::max(1.0, theirs[i].values.abs().maxCoeff()));
  }
}

EvidenceMix random_mix(Dice& dice, Eigen::Index rows) {
  return {rows,
          dice.chance(0.8),
          dice.chance(0.5),
          dice.chance(0.5),
          dice.chance(0.5),
          dice.chance(0.3),
          dice.chance(0.5),
          dice.between(0.001, 0.3)};
}

TEST(ResidualStatistics, EqualThoseOfPlainCode) {
  Dice dice(61);
  for (const InstructionSet set : available_instruction_sets())
    for (const Eigen::Index rows : {30, 31, 32, 33, 63, 64, 100, 500, 1023, 2000, 3001, 5000})
      for (const Eigen::Index surrogates : {1, 9, 40}) {
        SCOPED_TRACE(std::string(name_of(set)) + ", rows " + std::to_string(rows) + ", surrogates " +
                     std::to_string(surrogates));
        expect_reference(random_evidence(dice, random_mix(dice, rows)), surrogates, set);
      }
}

// More rows than are used: blocks begin and end within standstills and averaged rows.
TEST(ResidualStatistics, OfALongRecordAreThoseOfItsBlocks) {
  Dice dice(62);
  EvidenceMix mix;
  mix.rows = 70'007;
  const Evidence e = random_evidence(dice, mix);
  ASSERT_GT(sampled_ranges(e.rows(), 65536).size(), 1u);
  for (const InstructionSet set : available_instruction_sets()) expect_reference(e, 8, set);
}

// A reference without noise on halves and quarters of counts: every reading is on an edge, and its rounding
// must not depend on the kernel.
TEST(ResidualStatistics, RoundReadingsOnEdgesAsPlainCodeDoes) {
  for (const bool down : {false, true}) {
    Evidence e;
    e.encoder = {0.25, down ? Rounding::down : Rounding::nearest, true, 1};
    const Eigen::Index rows = 2000;
    e.time = 1e-3 * Eigen::ArrayXd::LinSpaced(rows, 0, static_cast<double>(rows - 1));
    e.path = Eigen::ArrayXd::NullaryExpr(
        rows, [](Eigen::Index k) { return 0.0625 * static_cast<double>(k % 997 - 500); });
    e.reference = e.path;
    e.velocity = e.direction = (e.path > 0).cast<double>() - 0.5;
    e.measured = e.path.unaryExpr([&](double x) { return quantize(e.encoder, x); });
    for (const bool ordered : {false, true}) {
      e.ordered = ordered;
      for (const InstructionSet set : available_instruction_sets()) expect_reference(e, 3, set);
    }
  }
}

// Exactly zero, not 1e-16 of a count.
TEST(ResidualStatistics, AreZeroByCountIfOneCountIsRead) {
  Dice dice(64);
  for (const InstructionSet set : available_instruction_sets())
    for (const Eigen::Index rows : {100, 3000}) {
      EvidenceMix mix;
      mix.rows = rows;
      Evidence e = random_evidence(dice, mix);
      e.path.setConstant(0.3 * e.step());
      e.measured.setZero();
      const std::vector<ResidualStatistic> all = residual_statistics(e, {}, 1, 7, 1, set);
      const auto by_count =
          std::find_if(all.begin(), all.end(), [](const auto& s) { return s.name == "by_count"; });
      ASSERT_NE(by_count, all.end());
      EXPECT_EQ(by_count->values[0], 0);
    }
}

void expect_same(const std::vector<ResidualStatistic>& a, const std::vector<ResidualStatistic>& b,
                 Eigen::Index values) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i)
    EXPECT_TRUE((a[i].values.head(values) == b[i].values.head(values)).all()) << a[i].name;
}

TEST(ResidualStatistics, AreIndependentOfThreadsAndOtherSurrogates) {
  Dice dice(63);
  const Evidence e = random_evidence(dice, random_mix(dice, 3000));
  const std::vector<Filter> filters = velocity_filters();
  for (const InstructionSet set : available_instruction_sets()) {
    const auto all = residual_statistics(e, filters, 99, 7, 1, set);
    for (const unsigned threads : {2u, 5u})
      expect_same(all, residual_statistics(e, filters, 99, 7, threads, set), 100);
    expect_same(all, residual_statistics(e, filters, 10, 7, 1, set), 11);
  }
}

}  // namespace
}  // namespace qerr
