
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <random>

#include "design/filter_choice.hpp"
#include "qerr/filter/family.hpp"
#include "qerr/filter/norms.hpp"

namespace qerr {
namespace {

/// Largest |H/(j w)^d - 1| over 2000 frequencies of the band.
double tracking_of(const std::vector<double>& h, const FirTask& task) {
  double largest = 0;
  for (int i = 1; i <= 2000; ++i) {
    const double w = 2 * M_PI * task.band * i / 2000;
    std::complex<double> sum = 0;
    for (std::size_t k = 0; k < h.size(); ++k)
      sum += h[k] * std::polar(1.0, -w * static_cast<double>(k) / task.sample_rate);
    largest = std::max(largest, std::abs(sum / std::pow(std::complex<double>(0, w), task.derivative) - 1.0));
  }
  return largest;
}

double norm_of(const std::vector<double>& h) {
  double sum = 0;
  for (const double v : h) sum += v * v;
  return std::sqrt(sum);
}

const std::vector<FirTask> tasks{{60, 1, 1000, 20, 0.1},  {200, 1, 1000, 5, 0.02}, {100, 2, 500, 4, 0.2},
                                 {40, 0, 1000, 50, 0.05}, {12, 1, 100, 20, 0.3},   {150, 1, 1000, 5, 0.5}};

TEST(QuietestFir, KeepsTheTrackingErrorAndReachesItsBound) {
  for (const FirTask& task : tasks) {
    const QuietestFir fir = quietest_fir(task);
    ASSERT_TRUE(fir.converged) << task.taps;
    EXPECT_LE(tracking_of(fir.h, task), 1.02 * task.tracking) << task.taps;
    EXPECT_NEAR(norm_of(fir.h), fir.h2, 1e-9 * fir.h2);
    // Slow motion passes as it is: the d-th moment is (-1)^d d!/T^d.
    double moment = 0;
    for (std::size_t k = 0; k < fir.h.size(); ++k)
      moment += fir.h[k] * std::pow(-static_cast<double>(k) / task.sample_rate, task.derivative);
    EXPECT_NEAR(moment / std::tgamma(task.derivative + 1), 1, 1e-6) << task.taps;
    // Primal and dual agree: no filter is quieter.
    EXPECT_NEAR(fir.h2, fir.h2_bound, 2e-3 * fir.h2) << task.taps;
  }
}

TEST(QuietestFir, NoFilterOfThatTrackingErrorAndMemoryFallsBelowTheBound) {
  std::mt19937_64 draw(1);
  for (const FirTask& task : tasks) {
    const QuietestFir best = quietest_fir(task);
    // Neighbours of the best one within the vanishing moments, and scaled ones: each with its own tracking
    // error.
    for (int i = 0; i < 20; ++i) {
      std::vector<double> h = best.h;
      std::normal_distribution<> normal(0, 0.02 * best.h2 / std::sqrt(static_cast<double>(h.size())));
      std::vector<double> change(h.size());
      for (std::size_t k = 0; k + 3 < h.size(); ++k) {
        const double v = normal(draw);  // (1, -3, 3, -1) has no moments of order 0 to 2
        change[k] += v;
        change[k + 1] -= 3 * v;
        change[k + 2] += 3 * v;
        change[k + 3] -= v;
      }
      for (std::size_t k = 0; k < h.size(); ++k) h[k] += change[k];
      FirTask own = task;
      own.tracking = tracking_of(h, task);
      if (own.tracking >= 1) continue;
      EXPECT_GE(norm_of(h), quietest_fir(own).h2_bound * (1 - 1e-6)) << task.taps;
    }
  }
}

TEST(QuietestFir, LowPassesAreNotQuieterThanTheBestOfTheirTrackingError) {
  for (const char* family : {"first_order", "butterworth", "bessel"})
    for (const double cutoff : {40.0, 90.0}) {
      const auto filter = low_pass(family, 2, cutoff, 1, 1000);
      ASSERT_TRUE(filter);
      const FirTask task{600, 1, 1000, 5, tracking_up_to(*filter, 5)};  // they have settled by then
      EXPECT_GT(h2_norm(*filter), quietest_fir(task).h2_bound) << family << cutoff;
    }
}

TEST(QuietestFir, TheBoundIsAboveTheFloorOfAllFilters) {
  // |H| >= (1 - e) (2 pi f)^d within the band, whatever the memory.
  for (const FirTask& task : tasks) {
    const double d = task.derivative, b = task.band;
    const double floor = (1 - task.tracking) * std::pow(2 * M_PI, d) *
                         std::sqrt(2 / task.sample_rate * std::pow(b, 2 * d + 1) / (2 * d + 1));
    EXPECT_GT(quietest_fir(task).h2_bound, floor);
  }
}

}  // namespace
}  // namespace qerr
