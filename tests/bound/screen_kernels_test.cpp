#include "bound/screen_kernels.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "support/random_chain.hpp"

namespace qerr {
namespace {

using testing::Dice;

/// Columns of some blocks and weights of a tile, small whole numbers: sums in float are exact.
struct Tile {
  std::size_t blocks, count;
  std::vector<float> columns, weights;

  Tile(Dice& dice, std::size_t some_blocks, std::size_t columns_of_each)
      : blocks(some_blocks),
        count(columns_of_each),
        columns(blocks * count * batch_size),
        weights(forms_per_tile * count) {
    for (float& x : columns) x = static_cast<float>(dice.below(8));
    for (float& w : weights) w = static_cast<float>(dice.below(5));
  }

  float value(std::size_t form, std::size_t configuration) const {
    const std::size_t block = configuration / batch_size, at = configuration % batch_size;
    float sum = 0;
    for (std::size_t k = 0; k < count; ++k)
      sum += weights[form * count + k] * columns[(block * count + k) * batch_size + at];
    return sum;
  }
};

TEST(ScreenKernels, HaveTheValuesOfPlainSums) {
  for (const InstructionSet set : available_instruction_sets()) {
    Dice dice(1);
    const Tile tile(dice, 3, 5);
    std::vector<float> to(forms_per_tile * tile.blocks * batch_size);
    select_kernels<ScreenKernels>(set).values(tile.columns.data(), tile.blocks, tile.count,
                                              tile.weights.data(), to.data());
    for (std::size_t f = 0; f < forms_per_tile; ++f)
      for (std::size_t i = 0; i < tile.blocks * batch_size; ++i)
        ASSERT_EQ(to[f * tile.blocks * batch_size + i], tile.value(f, i)) << f << ' ' << i;
  }
}

/// Bands in ascending order; the last may have no end, and some keep fewer values than they have.
TEST(ScreenKernels, KeepWhatLiesInTheBandsInItsOrder) {
  for (const InstructionSet set : available_instruction_sets())
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
      Dice dice(seed);
      const Tile tile(dice, 1 + dice.below(3), 1 + dice.below(4));
      const std::size_t configurations = tile.blocks * batch_size, per_form = 1 + seed % 3;
      std::vector<ScreenBand> bands(forms_per_tile * per_form);
      std::vector<std::vector<float>> values(bands.size(), std::vector<float>(configurations + 64));
      std::vector<std::vector<std::int32_t>> at(bands.size(), std::vector<std::int32_t>(configurations + 64));
      for (std::size_t f = 0; f < forms_per_tile; ++f) {
        auto limit = static_cast<float>(dice.below(20));
        for (std::size_t i = 0; i < per_form; ++i) {
          ScreenBand& band = bands[f * per_form + i];
          band.lower = limit;
          limit += static_cast<float>(1 + dice.below(12));
          const bool open = i + 1 == per_form && seed % 2 == 0;
          band.upper = open ? std::numeric_limits<float>::infinity() : limit;
          band.most = static_cast<std::uint32_t>(dice.chance(0.3) ? dice.below(20) : configurations);
          band.values = values[f * per_form + i].data();
          band.at = at[f * per_form + i].data();
        }
      }
      select_kernels<ScreenKernels>(set).screen(tile.columns.data(), tile.blocks, tile.count,
                                                tile.weights.data(), bands.data(), per_form);
      const bool only_top = per_form == 1 && seed % 2 == 0;  // below is not counted then
      for (std::size_t f = 0; f < forms_per_tile; ++f)
        for (std::size_t b = 0; b < per_form; ++b) {
          const ScreenBand& band = bands[f * per_form + b];
          std::uint32_t below = 0, count = 0;
          for (std::size_t i = 0; i < configurations; ++i) {
            const float value = tile.value(f, i);
            below += value < band.lower;
            if (value < band.lower || value >= band.upper) continue;
            if (count < band.most) {
              ASSERT_EQ(band.values[count], value);
              ASSERT_EQ(band.at[count], static_cast<std::int32_t>(i));
            }
            ++count;
          }
          ASSERT_EQ(band.count, count) << seed << ' ' << f << ' ' << b;
          if (!only_top) {
            ASSERT_EQ(band.below, below);
          }
        }
    }
}

TEST(ScreenKernels, CountAndFindValuesBetweenLimits) {
  for (const InstructionSet set : available_instruction_sets()) {
    const ScreenKernels& kernels = select_kernels<ScreenKernels>(set);
    for (std::uint32_t count = 0; count < 70; ++count) {
      Dice dice(count);
      std::vector<float> values(count + 16);
      std::vector<std::int32_t> at(count + 16), to(count + 16), wanted;
      for (std::uint32_t i = 0; i < count; ++i) {
        values[i] = static_cast<float>(dice.below(9));
        at[i] = static_cast<std::int32_t>(3 * i + 1);
      }
      std::uint32_t below = 0;
      for (std::uint32_t i = 0; i < count; ++i) {
        below += values[i] < 4;
        if (values[i] >= 2 && values[i] <= 5) wanted.push_back(at[i]);
      }
      EXPECT_EQ(kernels.below(values.data(), count, 4), below);
      to.resize(kernels.within(values.data(), at.data(), count, 2, 5, to.data()));
      EXPECT_EQ(to, wanted) << count;
    }
  }
}

/// Tolerance 1e-14 relative.
TEST(ScreenKernels, AddRootsOfSumsOfSquares) {
  for (const InstructionSet set : available_instruction_sets()) {
    Dice dice(3);
    const std::size_t configurations = 3 * batch_size;
    std::vector<std::vector<double>> columns(2, std::vector<double>(configurations));
    for (auto& column : columns)
      for (double& x : column) x = dice.between(-1, 1);
    const double* const pointers[]{columns[0].data(), columns[1].data()};
    const double weights[]{0.7, 1.9};
    std::vector<double> partial(batch_size);
    select_kernels<ScreenKernels>(set).root_sums(pointers, 2, weights, 0.3, configurations, partial.data());
    for (std::size_t i = 0; i < batch_size; ++i) {
      double sum = 0;
      for (std::size_t at = i; at < configurations; at += batch_size)
        sum += std::sqrt(0.7 * columns[0][at] * columns[0][at] + 1.9 * columns[1][at] * columns[1][at] + 0.3);
      EXPECT_NEAR(partial[i], sum, 1e-14 * sum);
    }
  }
}

}  // namespace
}  // namespace qerr
