#include "diagnose/terms/scan_kernels.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <vector>

#include "lanes/aligned.hpp"
#include "support/random_chain.hpp"

/// The kernels of the period scan against their formula.
namespace qerr {
namespace {

using testing::Dice;

double plain_power(const AlignedNumbers& score, const AlignedNumbers& argument, double rate) {
  std::complex<double> sum = 0;
  for (std::size_t k = 0; k < score.size(); ++k) sum += score[k] * std::polar(1.0, rate * argument[k]);
  return std::norm(sum);
}

double largest_power(const AlignedNumbers& score) {
  double sum = 0;
  for (std::size_t k = 0; k < score.size(); ++k) sum += std::abs(score[k]);
  return sum * sum;
}

TEST(ScanKernels, HaveThePowerOfEveryRate) {
  Dice dice(71);
  for (const InstructionSet set : available_instruction_sets())
    for (const std::size_t rows : {32, 64, 96, 1024})
      for (const std::size_t count : {1, 63, 64, 65, 1998}) {
        SCOPED_TRACE(std::string(name_of(set)) + ", " + std::to_string(rows) + " rows, " +
                     std::to_string(count) + " rates");
        AlignedNumbers score(rows), angle(rows), scratch(4 * rows + 2 * scanned_at_once * 8);
        for (std::size_t k = 0; k < rows; ++k)
          score[k] = dice.between(-1, 1), angle[k] = dice.between(0, 1.6);
        const double first = std::floor(dice.between(1, 20)), most = largest_power(score);
        std::vector<double> powers(count);
        select_kernels<ScanKernels>(set).powers(score.data(), angle.data(), rows, first, count,
                                                scratch.data(), powers.data());
        for (std::size_t i = 0; i < count; i += 1 + count / 50) {
          const double rate = first + static_cast<double>(i);
          const double expected = plain_power(score, angle, rate);
          EXPECT_NEAR(powers[i], expected, 1e-12 * most) << i;
          EXPECT_NEAR(select_kernels<ScanKernels>(set).power(score.data(), angle.data(), rows, rate),
                      expected, 1e-12 * most);
        }
      }
}

}  // namespace
}  // namespace qerr
