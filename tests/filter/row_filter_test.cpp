#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "filter/run/cascade.hpp"
#include "support/design_filter.hpp"
#include "support/random_chain.hpp"
#include "support/reference_filter.hpp"

namespace qerr {
namespace {

using testing::Dice;
using testing::ReferenceFilter;

constexpr std::size_t most_rows = 64;

/// Fast and slow ones, with a notch, with and without taps.
std::vector<Filter> filters() {
  std::vector<Filter> filters{cascade(0, 1),       cascade(1, 1),       cascade(1, 2), cascade(2, 2),
                              cascade(2, 3, 0.01), cascade(1, 1, 1e-3), Filter{}};
  filters.push_back(design_filter("butterworth", 2, 1000, 4, 20));
  filters.push_back(design_filter("butterworth", 0, 1000, 3, 100));
  filters.back().gain = 3;
  filters.push_back({{}, 0.5, 1000, 0, {0.1, -0.4, 0.2, 1}});
  filters.push_back({{}, 2, 1000, 0, std::vector<DoubleDouble>(200, 0.01)});
  filters.push_back({{{{1, 0.2, 3}, {1, 2, 3}}, {{0.5, -1, 0}, {1, 4, 0}}}, 0.7, 1000});
  return filters;
}

TEST(Cascade, EqualsTheReference) {
  for (const Filter& filter : filters()) {
    Cascade<double> cascade(filter);
    Cascade<DoubleDouble> accurate(filter);
    ReferenceFilter reference(filter, 1);
    Eigen::ArrayXd x(1);
    double largest = 0;
    for (int k = 0; k < 300; ++k) {
      const double input = k % 7 < 3 ? 1.0 : -0.5;
      x[0] = input;
      reference.step(x);
      const auto expected = static_cast<double>(accurate.step(input));
      largest = std::max(largest, std::abs(expected));
      EXPECT_NEAR(cascade.step(input), expected, 1e-12 * largest);
      EXPECT_NEAR(x[0], expected, 1e-12 * largest);
    }
  }
}

TEST(RowFilter, EqualsTheReferenceForAnyNumberOfRowsPerCall) {
  Dice dice(45);
  const std::vector<Filter> all = filters();
  for (const InstructionSet set : available_instruction_sets())
    for (std::size_t f = 0; f < all.size(); ++f)
      for (const std::size_t width : {8, 24, 40, 56}) {
        const auto channels = static_cast<Eigen::Index>(width);
        ReferenceFilter reference(all[f], channels);
        RowFilter filter(all[f], width, most_rows, set);
        AlignedNumbers rows(2 * most_rows * width), out(most_rows * width);
        for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = 1e-4 * dice.between(0.5, 1);
        reference.settle(Eigen::Map<const Eigen::ArrayXd>(rows.data(), channels));
        filter.settle(rows.data());
        double scale = 0, worst = 0;
        for (const std::size_t piece : {64, 1, 63, 17, 2, 64, 64}) {
          const std::size_t stride = piece % 2 == 1 ? 2 * width : width;
          filter(rows.data(), stride, piece, out.data());
          for (std::size_t row = 0; row < piece; ++row) {
            Eigen::ArrayXd x = Eigen::Map<const Eigen::ArrayXd>(rows.data() + row * stride, channels);
            reference.step(x);
            const Eigen::Map<const Eigen::ArrayXd> y(out.data() + row * width, channels);
            scale = std::max(scale, x.abs().maxCoeff());
            worst = std::max(worst, (x - y).abs().maxCoeff());
          }
        }
        EXPECT_LT(worst, 1e-12 * scale) << name_of(set) << ", filter " << f << ", width " << width;
        filter.reset();
        ReferenceFilter fresh(all[f], channels);
        Eigen::ArrayXd x = Eigen::Map<const Eigen::ArrayXd>(rows.data(), channels);
        fresh.step(x);
        filter(rows.data(), width, 1, out.data());
        EXPECT_LT((x - Eigen::Map<const Eigen::ArrayXd>(out.data(), channels)).abs().maxCoeff(),
                  1e-12 * scale);
      }
}

}  // namespace
}  // namespace qerr
