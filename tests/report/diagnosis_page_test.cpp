#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "report/diagnosis/parts.hpp"
#include "report/page/page.hpp"

namespace qerr {
namespace {

TEST(Envelope, KeepsTheSmallestAndTheLargestOfEachInterval) {
  page::Envelope e(0, 10, 2);
  for (const auto& [x, y] : {std::pair{4.0, 1.0}, {1.0, 7.0}, {2.0, -3.0}, {3.0, 2.0}, {10.0, 5.0}})
    e.add(x, y);
  const std::vector<std::pair<double, double>> wanted{{1, 7}, {2, -3}, {10, 5}};
  EXPECT_EQ(e.points(), wanted);
}

TEST(Envelope, CoversARecordAtOneInstant) {
  page::Envelope e(3, 3, 4);
  e.add(3, 1), e.add(3, 2);
  EXPECT_EQ(e.points().size(), 2u);
}

TEST(IsolatedRuns, KeepTheOrderOfWhatIsBesideThem) {
  EXPECT_EQ(page::isolated_runs("elbow: 4 counts"), "elbow: 4 counts");
  EXPECT_EQ(page::isolated_runs("\u05D0 \u05D1: 4"), "\u200E\u2068\u05D0 \u05D1\u2069: 4");
  EXPECT_EQ(page::isolated_runs("of \u0627 and \u05D1 "),
            "\u200Eof \u2068\u0627\u2069 and \u2068\u05D1\u2069 ");
  EXPECT_EQ(page::isolated_runs("\xff"), "\xff");
}

TEST(HalfSpectrum, IsTheSumOfItsDefinition) {
  const std::vector<double> values{1, -2, 0.5, 4, 0, 3};
  const auto spectrum = half_spectrum(values);
  ASSERT_EQ(spectrum.size(), 4u);
  for (std::size_t n = 0; n < spectrum.size(); ++n) {
    std::complex<double> sum = 0;
    for (std::size_t k = 0; k < values.size(); ++k)
      sum += values[k] * std::polar(1.0, -2 * std::numbers::pi * static_cast<double>(n * k) / 6);
    EXPECT_NEAR(std::abs(spectrum[n] - sum), 0, 1e-12);
  }
}

/// A sine of an order of the joint's position, over two revolutions forth and back.
JointResidual sine_residual(double order, double amplitude) {
  constexpr Eigen::Index rows = 20000;
  JointResidual r;
  Evidence& e = r.evidence;
  e.joint = "axis";
  e.encoder.resolution = 1e-3;
  e.time = Eigen::ArrayXd::LinSpaced(rows, 0, 20);
  e.reference = 2 * std::numbers::pi * (1 - (std::numbers::pi / 20 * e.time).cos());
  e.path = e.reference;
  e.direction = (std::numbers::pi / 20 * e.time).sin().sign();
  r.before = amplitude * (order * e.reference).sin();
  r.after = 0 * r.before;
  e.measured = e.reference + r.before;
  return r;
}

TEST(PositionSpectrum, HasTheAmplitudeAtTheOrder) {
  const PositionSpectrum s = position_spectrum(sine_residual(9, 2e-4));
  ASSERT_FALSE(s.order.empty());
  const auto peak = std::max_element(s.before.begin(), s.before.end()) - s.before.begin();
  EXPECT_NEAR(s.order[static_cast<std::size_t>(peak)], 9, 0.02);
  EXPECT_NEAR(s.before[static_cast<std::size_t>(peak)], 2e-4, 2e-6);
  EXPECT_EQ(*std::max_element(s.after.begin(), s.after.end()), 0);
}

TEST(ResidualPicture, DrawsTheSameExtremesWithFewPoints) {
  const JointResidual r = sine_residual(9, 2e-4);
  const ResidualPicture p = residual_picture(r, 50);
  EXPECT_LE(p.before.size(), 100u);
  EXPECT_TRUE(p.corrected);
  double largest = 0;
  for (const auto& point : p.sides[0].before) largest = std::max(largest, point.second);
  EXPECT_NEAR(largest, 2e-4, 1e-8);
  EXPECT_DOUBLE_EQ(p.rms_before, std::sqrt(r.before.square().mean()));
  EXPECT_EQ(p.rms_after, 0);
  // What was subtracted is all of it.
  for (const auto& [x, y] : p.sides[0].fit) EXPECT_LE(std::abs(y), 2e-4);
}

TEST(ResidualPicture, OfAJointAtRestIsDrawnInTimeAlone) {
  JointResidual r = sine_residual(9, 0);
  // Noise of the reference is no motion.
  r.evidence.reference = 1e-4 * (7 * r.evidence.time).sin();
  r.evidence.path = r.evidence.reference;
  r.evidence.measured.setConstant(1e-3);
  r.before = r.after = r.evidence.measured;
  const ResidualPicture p = residual_picture(r, 50);
  EXPECT_FALSE(p.before.empty());
  EXPECT_TRUE(p.sides[0].before.empty() && p.spectrum_before.empty() && p.by_count_before.empty());
}

}  // namespace
}  // namespace qerr
