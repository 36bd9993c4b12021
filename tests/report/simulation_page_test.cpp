#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/random.hpp"
#include "qerr/report/simulation_report.hpp"
#include "qerr/report/write.hpp"
#include "report/simulation/parts.hpp"

namespace qerr {
namespace {

double square_of(const std::vector<std::pair<double, double>>& density) {
  double sum = 0;
  for (const auto& [frequency, value] : density) sum += value * value * density.front().first;
  return sum;
}

TEST(AmplitudeDensity, OfASineHasItsMeanSquareAtItsFrequency) {
  std::vector<double> values;
  for (int k = 0; k < 20000; ++k) values.push_back(3 + 2 * std::sin(2 * std::numbers::pi * 0.0625 * k));
  const auto density = amplitude_density(values, 1000);
  const auto peak = std::max_element(density.begin(), density.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  EXPECT_DOUBLE_EQ(peak->first, 62.5);
  EXPECT_NEAR(square_of(density), 2, 1e-6);
}

TEST(AmplitudeDensity, OfWhiteValuesIsFlat) {
  std::vector<double> values;
  for (std::uint64_t k = 0; k < 100000; ++k) values.push_back(unit_interval(random_bits(1, k, 0)) - 0.5);
  const auto density = amplitude_density(values, 500);
  EXPECT_NEAR(square_of(density), 1.0 / 12, 2e-3);
  double low = 0;
  for (std::size_t i = 0; i < density.size() / 4; ++i) low += density[i].second * density[i].second;
  EXPECT_NEAR(low / static_cast<double>(density.size() / 4), 2.0 / 12 / 500, 2e-5);
}

TEST(AmplitudeDensity, NeedsSomeValues) {
  EXPECT_TRUE(amplitude_density(std::vector<double>(31, 1.0), 1).empty());
}

/// The statistics of the kept errors are those of the simulation.
TEST(ErrorTrace, HasTheSigmaOfTheReport) {
  const Spec spec = read_spec(std::string(QERR_SOURCE_DIR) + "/configs/diagnosis/spec.yaml");
  SimulationOptions options;
  options.traced = std::uint64_t{1} << 20;
  const SimulationReport r = simulation_report(spec, options);
  ASSERT_EQ(r.simulation.traces.size(), r.simulation.results.size());
  for (std::size_t o = 0; o < r.simulation.traces.size(); ++o) {
    const ErrorTrace& trace = r.simulation.traces[o];
    ASSERT_EQ(trace.error.size(), r.simulation.results[o].size());
    for (std::size_t c = 0; c < trace.error.size(); ++c) {
      const Eigen::Map<const Eigen::ArrayXd> e(trace.error[c].data(),
                                               static_cast<Eigen::Index>(trace.error[c].size()));
      const SimulatedSignal& s = r.simulation.results[o][c];
      EXPECT_NEAR(std::sqrt((e - e.mean()).square().mean()), s.sigma_simulated, 1e-9 * s.sigma_simulated);
      EXPECT_NEAR(e.abs().maxCoeff(), s.peak_simulated, 1e-9 * s.peak_simulated);
    }
  }
}

TEST(ErrorTrace, IsLimitedAndLeavesTheReportAsItIs) {
  const Spec spec = read_spec(std::string(QERR_SOURCE_DIR) + "/configs/diagnosis/spec.yaml");
  SimulationOptions options;
  SimulationReport without = simulation_report(spec, options);
  options.traced = 100;
  const SimulationReport with = simulation_report(spec, options);
  for (const ErrorTrace& trace : with.simulation.traces) EXPECT_LE(trace.error.at(0).size(), 100u);
  EXPECT_TRUE(without.simulation.traces.empty());
  EXPECT_EQ(write(with, "json"), write(without, "json"));
}

}  // namespace
}  // namespace qerr
