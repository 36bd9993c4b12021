#include "simulate/fused_filter.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/design_filter.hpp"
#include "support/random_chain.hpp"
#include "support/reference_filter.hpp"

namespace qerr {
namespace {

using testing::Dice;

/// Fast and slow filters, with and without separate sections for derivatives, and with more sections than one
/// pass processes.
std::vector<Filter> filters() {
  std::vector<Filter> all;
  for (const double cutoff : {2.0, 20.0, 200.0})
    for (int derivative = 0; derivative <= 2; ++derivative)
      for (int order = 1; order <= 5; ++order)
        for (const char* family : {"first_order", "butterworth"})
          if (std::string(family) == "butterworth" || order >= derivative)
            all.push_back(design_filter(family, derivative, 1000, order, cutoff));
  all.push_back(design_filter("first_order", 0, 1000, 2, 0.2));
  all.push_back({{}, 0.5, 1000, 0, {0.1, -0.4, 0.2, 1}});
  Filter negative = design_filter("butterworth", 0, 1000, 3, 100);
  negative.gain = -3;
  all.push_back(negative);
  // Sections other than low-passes: a notch, and a high-shelf.
  Filter notch = negative;
  for (Section& s : notch.sections)
    if (s.a[2] != 0) s.b = {1, 0, 3};
  all.push_back(notch);
  for (Section& s : notch.sections) s.b = {1, 0.5L, 0};
  all.push_back(notch);
  return all;
}

/// Mean, variance and peak of each channel of the reference's output after the first `settling` rows.
struct Figures {
  Eigen::ArrayXd mean, variance, peak;
};
Figures by_bank(const Filter& filter, const AlignedNumbers& rows, std::size_t width, std::size_t settling) {
  const auto channels = static_cast<Eigen::Index>(width);
  testing::ReferenceFilter bank(filter, channels);
  bank.settle(Eigen::Map<const Eigen::ArrayXd>(rows.data(), channels));
  std::vector<Eigen::ArrayXd> out;
  for (std::size_t row = 0; row < rows.size() / width; ++row) {
    Eigen::ArrayXd x = Eigen::Map<const Eigen::ArrayXd>(rows.data() + row * width, channels);
    bank.step(x);
    if (row >= settling) out.push_back(x);
  }
  const Eigen::ArrayXd zero = Eigen::ArrayXd::Zero(channels);
  Figures f{zero, zero, zero};
  for (const auto& x : out) f.mean += x / static_cast<double>(out.size());
  for (const auto& x : out) {
    f.variance += (x - f.mean).square() / static_cast<double>(out.size());
    f.peak = f.peak.max(x.abs());
  }
  return f;
}

TEST(FusedFilter, HasTheStatisticsOfTheReference) {
  Dice dice(61);
  const std::size_t settling = 70, peaks = 3;
  const std::vector<std::size_t> pieces{64, 6, 64, 1, 63, 17, 64, 64};
  for (const std::size_t width : {8, 24, 40, 56}) {
    AlignedNumbers rows(343 * width);
    for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = 1e-4 * dice.between(-1, 1.5);
    int number = 0;
    for (const Filter& filter : filters()) {
      const Figures expected = by_bank(filter, rows, width, settling);
      for (const InstructionSet set : available_instruction_sets()) {
        RunStatistics statistics(static_cast<Eigen::Index>(width), peaks, width, 2,
                                 select_kernels<SimulationKernels>(set));
        FusedFilter tallied(filter, width, set);
        tallied.settle(rows.data());
        std::size_t row = 0;
        for (const std::size_t piece : pieces) {
          const double* const in = rows.data() + row * width;
          if (row < settling)
            tallied.pass(in, width, piece);
          else
            tallied.tally(in, width, piece, row < 200 ? 0 : 1, statistics);
          row += piece;
        }
        statistics.finish();
        for (Eigen::Index c = 0; c < expected.mean.size(); ++c) {
          // Rounding errors are relative to the input, of which a slow filter passes little but the mean;
          // second derivatives below 2 Hz lose another digit in any form of the sections.
          const double sigma = std::sqrt(expected.variance[c]), size = sigma + std::abs(expected.mean[c]);
          const auto where = [&] {
            return std::string(name_of(set)) + ", filter " + std::to_string(number) + ", width " +
                   std::to_string(width);
          };
          EXPECT_NEAR(statistics.mean(c), expected.mean[c], 1e-11 * size) << where();
          EXPECT_NEAR(statistics.variance(c), expected.variance[c], 1e-11 * sigma * size) << where();
          if (c < static_cast<Eigen::Index>(peaks)) {
            EXPECT_NEAR(statistics.peak(c), expected.peak[c], 1e-11 * expected.peak[c]) << where();
          }
        }
      }
      ++number;
    }
  }
}

}  // namespace
}  // namespace qerr
