#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "bound/batched_error.hpp"
#include "bound/kernels.hpp"
#include "bound/workspace_job.hpp"
#include "lanes/batch.hpp"
#include "qerr/bound/figure.hpp"
#include "support/random_model.hpp"

namespace qerr {
namespace {

using testing::Dice;

/// Leading bits of values over `octaves`, some of them equal, tiny or infinite.
std::vector<std::int32_t> random_bins(Dice& dice, std::size_t count, double octaves, double infinite) {
  std::vector<std::int32_t> bins;
  for (std::size_t i = 0; i < count; ++i) {
    double value = std::exp2(dice.between(-octaves, 0));
    if (dice.chance(0.02)) value = 0;
    if (dice.chance(infinite)) value = std::numeric_limits<double>::infinity();
    bins.push_back(leading_bits(value));
  }
  return bins;
}

TEST(SampledBinsFigures, OrderStatisticsAreThoseOfTheSortedBins) {
  Dice dice(71);
  const std::int32_t infinite = leading_bits(std::numeric_limits<double>::infinity());
  for (int trial = 0; trial < 60; ++trial) {
    std::vector<std::int32_t> bins =
        random_bins(dice, 1 + dice.below(400), trial % 2 == 0 ? 3 : 90, trial % 3 == 0 ? 0.1 : 0);
    if (trial == 0) std::fill(bins.begin(), bins.end(), infinite);
    const SampledBins sample(bins.data(), bins.data() + bins.size());
    std::sort(bins.begin(), bins.end());
    // 64 octaves below the largest finite one, and one bin for all infinite ones.
    std::int32_t beyond = infinite;
    for (const std::int32_t bin : bins)
      if (bin < infinite) beyond = bin + 1;
    const std::int32_t first = std::max(bins.front(), beyond - static_cast<std::int32_t>(bin_count));
    for (std::size_t rank = 0; rank < bins.size(); ++rank)
      ASSERT_EQ(sample[rank], std::clamp(bins[rank], first, beyond)) << trial << ' ' << rank;
    EXPECT_EQ(sample.usual().first, first);
    EXPECT_EQ(sample.usual().count, beyond - first + 1 + 1024) << "an octave more";
  }
}

/// 4.5 standard deviations of a sampled percentile on either side.
TEST(SampledBinsFigures, CountedBinsSurroundThePercentiles) {
  Dice dice(72);
  for (int trial = 0; trial < 40; ++trial) {
    const double count = trial < 4 ? 20 : 1000 + static_cast<double>(dice.below(5000));
    std::vector<std::int32_t> bins = random_bins(dice, static_cast<std::size_t>(count), 8, 0);
    const CountedBins counted = SampledBins(bins.data(), bins.data() + bins.size()).near_percentiles();
    std::sort(bins.begin(), bins.end());
    const std::int32_t first = std::max(bins.front(), bins.back() + 1 - static_cast<std::int32_t>(bin_count));
    const auto bin_at = [&](double fraction, double deviations) {
      const double rank = fraction * count + deviations * std::sqrt(count * fraction * (1 - fraction));
      const std::int32_t bin = bins[static_cast<std::size_t>(std::clamp(rank, 0.0, count - 1))];
      return std::max(bin, first);
    };
    const auto begin = [&](std::int32_t bin) { return bin == first ? CountedBins::first : bin; };
    EXPECT_EQ(counted.begin, begin(bin_at(0.5, -4.5)));
    EXPECT_EQ(counted.end, bin_at(0.5, 4.5) + 1);
    EXPECT_EQ(counted.top, begin(bin_at(0.95, -4.5)));
    EXPECT_TRUE(counted(counted.end - 1));
    EXPECT_TRUE(counted(counted.top));
    EXPECT_EQ(counted(counted.end), counted.end >= counted.top);
  }
}

/// Values of some figures at some batches, with ties and values that differ by less than `same_maximum`.
struct CountedFigures {
  static constexpr std::size_t figures = 5, batches = 12;
  AlignedNumbers values{figures * batches * batch_size};  // [batch][figure][configuration]

  explicit CountedFigures(Dice& dice) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double value = dice.between(0, 4);
      values[i] = (i / batch_size) % figures == 2 ? std::ceil(value) : std::exp2(-3 * value);
      if (dice.chance(0.2)) values[i] *= 1 + 1e-14;
    }
  }
  const double* batch(std::size_t b) const { return values.data() + b * figures * batch_size; }
  double at(std::size_t figure, std::size_t configuration) const {
    return batch(configuration / batch_size)[figure * batch_size + configuration % batch_size];
  }
};

TEST(TallyKernels, AreThoseOfPlainLoops) {
  for (const InstructionSet set : available_instruction_sets())
    for (std::uint64_t seed = 0; seed < 8; ++seed) {
      Dice dice(7300 + seed);
      const CountedFigures counted(dice);
      constexpr std::size_t figures = CountedFigures::figures, all = CountedFigures::batches * batch_size;
      std::vector<Tally> tallies(figures);
      const double known = seed % 3 == 0 ? 0.5 : -1;  // a maximum of earlier blocks
      for (Tally& t : tallies) t.max = known;
      std::vector<Histogram> empty;
      for (std::size_t f = 0; f < figures; ++f) {
        CountedBins bins;
        const double low = std::exp2(-dice.between(5, 9));
        const double high = std::exp2(-dice.between(2, 5));
        if (seed % 2 == 0) bins = {leading_bits(low), leading_bits(high), leading_bits(4 * high)};
        empty.emplace_back(Histogram::lowest_bin(leading_bits(1)), bins);
      }
      BlockCounts counts(empty);
      for (std::size_t b = 0; b < CountedFigures::batches; ++b)
        select_kernels<BoundKernels>(set).tally(figures, counted.batch(b), 1000 + b * batch_size,
                                                tallies.data(), seed % 4 < 3 ? counts.lists() : nullptr);
      for (std::size_t f = 0; f < figures; ++f) {
        double sum = 0, most = 0, least = 1e9;
        std::uint64_t first = Tally::none;
        std::vector<std::int32_t> listed;
        std::int32_t below = 0;
        for (std::size_t i = 0; i < all; ++i) {
          const double value = counted.at(f, i);
          sum += value;
          most = std::max(most, value);
          least = std::min(least, value);
          if (empty[f].counted()(leading_bits(value))) listed.push_back(leading_bits(value));
          below += !empty[f].counted()(leading_bits(value)) && leading_bits(value) < empty[f].counted().begin;
        }
        for (std::size_t i = all; i-- > 0;)
          if (counted.at(f, i) * same_maximum >= most) first = 1000 + i;
        const Tally& t = tallies[f];
        double found = 0;
        for (const double lane : t.sum) found += lane;
        EXPECT_NEAR(found, sum, 1e-13 * sum);
        EXPECT_EQ(*std::min_element(t.min, t.min + 8), least);
        EXPECT_EQ(t.max, std::max(most, known));
        EXPECT_EQ(t.at_max, most > known ? first : Tally::none);
        if (seed % 4 == 3) continue;
        const BinList& list = counts.lists()[f];
        EXPECT_EQ(std::vector<std::int32_t>(counts.list(f), list.next), listed);
        std::int32_t found_below = 0;
        for (const std::int32_t lane : list.below) found_below += lane;
        EXPECT_EQ(found_below, below);
      }
      if (seed % 4 == 3) continue;
      counts.end_of_block(all);
      for (std::size_t f = 0; f < figures; ++f) {
        Histogram plain(empty[f]);
        std::vector<double> sorted;
        for (std::size_t i = 0; i < all; ++i) {
          plain.add(counted.at(f, i));
          sorted.push_back(counted.at(f, i));
        }
        std::sort(sorted.begin(), sorted.end());
        for (std::size_t rank = 0; rank < all; rank += 5) {
          const Histogram& of_block = counts.histograms()[f];
          ASSERT_EQ(of_block.counts(rank), plain.counts(rank));
          if (!plain.counts(rank)) continue;
          const double value = of_block.order_statistic(rank, sorted.front(), sorted.back());
          ASSERT_EQ(value, plain.order_statistic(rank, sorted.front(), sorted.back()));
          EXPECT_NEAR(value, sorted[rank], 1e-3 * sorted[rank]);
        }
        EXPECT_EQ(counts.lists()[f].next, counts.list(f)) << "the lists are cleared";
      }
    }
}

/// A histogram's few usual bins, and all others, count what plain bins do, also in several parts.
TEST(HistogramFigures, AddListsAsSingleValues) {
  Dice dice(74);
  for (int trial = 0; trial < 20; ++trial) {
    const std::int32_t lowest = Histogram::lowest_bin(leading_bits(std::exp2(dice.between(-20, 20))));
    const auto first = lowest + static_cast<std::int32_t>(dice.below(60000));
    const auto count = static_cast<std::int32_t>(dice.below(20000));
    Histogram listed(lowest, {}, {first, count}), single(lowest);
    std::vector<double> values;
    for (std::size_t part = 0; part < 3; ++part) {
      std::vector<std::int32_t> bins;
      for (std::size_t i = dice.below(200); i > 0; --i) {
        values.push_back(std::exp2(dice.between(-60, 30)));
        bins.push_back(leading_bits(values.back()));
        single.add(values.back());
      }
      listed.add(bins.data(), bins.size(), 0, 0);
    }
    std::sort(values.begin(), values.end());
    for (std::size_t rank = 0; rank < values.size(); rank += 3)
      ASSERT_EQ(listed.order_statistic(rank, values.front(), values.back()),
                single.order_statistic(rank, values.front(), values.back()));
  }
}

/// What is below the span is counted in its lowest bin, if that is counted.
TEST(HistogramFigures, CountedBinsBelowTheSpanAreItsLowestOne) {
  const std::int32_t lowest = Histogram::lowest_bin(leading_bits(1));
  const auto expect = [&](const CountedBins& wanted, std::int32_t begin, std::int32_t end, std::int32_t top) {
    const CountedBins counted = Histogram(lowest, wanted).counted();
    EXPECT_EQ(counted.begin, begin);
    EXPECT_EQ(counted.end, end);
    EXPECT_EQ(counted.top, top);
  };
  constexpr std::int32_t all = CountedBins::first;
  expect({lowest - 9, lowest + 500, lowest + 900}, all, lowest + 500, lowest + 900);
  expect({lowest, lowest + 1, lowest + 2}, all, lowest + 1, lowest + 2);
  expect({lowest - 9, lowest - 5, lowest}, all, lowest + 1, all);
  expect({lowest + 1, lowest + 5, lowest + 6}, lowest + 1, lowest + 5, lowest + 6);
}

TEST(HistogramFigures, LowestBinIsFortyOctavesBelowTheTypicalValue) {
  for (const double typical : {1e-3, 1.0, 1.5, 1e6, 1e200})
    EXPECT_EQ(Histogram::lowest_bin(leading_bits(typical)),
              leading_bits(std::exp2(std::floor(std::log2(typical)) - 40)));
  const std::int32_t of_one = Histogram::lowest_bin(leading_bits(1));
  EXPECT_EQ(Histogram::lowest_bin(leading_bits(0)), of_one);
  EXPECT_EQ(Histogram::lowest_bin(leading_bits(std::numeric_limits<double>::infinity())), of_one);
  EXPECT_EQ(Histogram::lowest_bin(leading_bits(std::exp2(901))), of_one);
  EXPECT_EQ(Histogram::lowest_bin(leading_bits(std::exp2(900))), leading_bits(std::exp2(860)));
  EXPECT_EQ(Histogram::lowest_bin(leading_bits(std::exp2(-1000))), 0);
}

/// The covariance of every configuration, as figures.
TEST(BatchedErrorFigures, HaveTheCovarianceOfEveryConfiguration) {
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    Dice dice(7500 + seed);
    OperationalModel m = testing::random_model(dice, 0, seed % 3 == 0 ? 1 : 0);
    std::erase_if(m.coordinates, is_euler_angle);
    if (m.coordinates.empty()) m.coordinates = {Coordinate::x};
    AlignedNumbers q(m.chain.independent.size() * batch_size);
    for (std::size_t i = 0; i < q.size(); ++i) q[i] = dice.between(-3, 3);
    for (const InstructionSet set : available_instruction_sets()) {
      BatchedError batched(m, {.rigorous = seed % 2 == 0, .shares = false, .covariance = true}, set);
      const FigureLayout& at = batched.figures();
      AlignedNumbers figures(at.count * batch_size);
      batched(q.data(), figures.data());
      for (std::size_t i = 0; i < batch_size; ++i) {
        Eigen::VectorXd here(static_cast<Eigen::Index>(m.chain.independent.size()));
        for (Eigen::Index j = 0; j < here.size(); ++j)
          here[j] = q[static_cast<std::size_t>(j) * batch_size + i];
        const OperationalError e = operational_error(m, here);
        const Eigen::MatrixXd expected = covariance(e);
        const double size = expected.diagonal().maxCoeff();
        std::size_t entry = 0;
        for (Eigen::Index r = 0; r < expected.rows(); ++r) {
          const auto row = static_cast<std::size_t>(r);
          EXPECT_NEAR(figures[(at.worst_case + row) * batch_size + i], e.worst_case[r],
                      1e-12 * e.worst_case.maxCoeff());
          for (Eigen::Index c = 0; c <= r; ++c)
            EXPECT_NEAR(figures[(at.covariance + entry++) * batch_size + i], expected(r, c), 1e-12 * size);
        }
      }
    }
  }
}

}  // namespace
}  // namespace qerr
