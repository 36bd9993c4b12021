#include <gtest/gtest.h>

#include <cmath>
#include <sstream>
#include <string>

#include "filter/norms/autocorrelation.hpp"
#include "qerr/filter/norms.hpp"
#include "support/measured.hpp"
#include "support/random_filter.hpp"
#include "support/sample_filters.hpp"

/// All figures of many filters, with the widths of the proven intervals: that the intervals hold is tested
/// elsewhere, against sums of 100 digits; one that is wider than it was holds as well. The values are those
/// of the program itself (`Measured`).
namespace qerr {
namespace {

/// Logarithm of an error relative to the value: errors of rounding differ between processors.
double size_of_error(double error, double value) { return std::log2(1e-15 + error / value); }

void expect_norms(const std::string& name, const Filter& filter) {
  const testing::Measured measured("filter_figures.csv", 1e-8), errors("filter_figures.csv", 0.005);
  const Norms n = norms(filter);
  measured.expect(name + ",h2", n.h2);
  errors.expect(name + ",error of h2", size_of_error(n.h2_error, n.h2));
  measured.expect(name + ",l1", n.l1.upper);
  errors.expect(name + ",width of l1", size_of_error(n.l1.upper - n.l1.lower, n.l1.upper));
}

void expect_quality(const std::string& name, const Filter& filter) {
  const testing::Measured measured("filter_figures.csv", 1e-8);
  const double h2 = h2_norm(filter), half_rate = filter.sample_rate / 2;
  measured.expect(name + ",low-frequency gain", low_frequency_gain(filter));
  measured.expect(name + ",bandwidth", bandwidth(filter).value_or(-1));
  measured.expect(name + ",noise bandwidth", noise_bandwidth(filter, h2));
  measured.expect(name + ",settling to 2 %", settling_time(filter).value_or(-1));
  measured.expect(name + ",settling to 1e-7", settling_time(filter, 1e-7).value_or(-1));
  measured.expect(name + ",rise of the noise", noise_rise_time(filter).value_or(-1));
  const BandTracking low = band_tracking(filter, 0, 0.002 * half_rate),
                     all = band_tracking(filter, 0.01 * half_rate, 0.9 * half_rate);
  measured.expect(name + ",largest in the low band", low.largest);
  measured.expect(name + ",rms in the low band", low.rms);
  measured.expect(name + ",largest in the band", all.largest);
  measured.expect(name + ",rms in the band", all.rms);
  const Fidelity at = fidelity(filter, 0.07 * half_rate);
  measured.expect(name + ",gain error", at.gain_error);
  measured.expect(name + ",phase error", at.phase_error);
  measured.expect(name + ",tracking error", at.tracking_error);
}

TEST(FilterFigures, OfTheSamplesAreThoseMeasured) {
  std::size_t index = 0;
  for (const SampleFilter& sample : sample_filters()) {
    const std::string name = std::to_string(index++) + ' ' + sample.family + ' ';
    for (const int d : {0, 1, sample.most_derivative}) {
      const Filter filter = designed(sample, d);
      expect_norms(name + std::to_string(d), filter);
      if (d < 2) expect_quality(name + std::to_string(d), filter);
    }
  }
}

TEST(FilterFigures, OfSlowSamplesAreThoseMeasured) {
  std::size_t index = 0;
  for (SampleFilter sample : sample_filters()) {
    const std::string name = std::to_string(index++) + ' ' + sample.family + " slow ";
    if (!sample.numbers.contains("cutoff")) continue;
    sample.numbers["order"] = index % 2 == 0 ? 7 : 2;
    for (const double cutoff : {0.003, 2.0}) {
      sample.numbers["cutoff"] = cutoff;
      std::ostringstream full;
      full << name << cutoff << " Hz";
      expect_norms(full.str(), designed(sample, 1));
      expect_quality(full.str(), designed(sample, 1));
    }
  }
}

TEST(FilterFigures, OfRandomCascadesAreThoseMeasured) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    const double slowest = seed % 4 == 0 ? 0.3 : seed % 4 == 1 ? 1e-2 : seed % 4 == 2 ? 1e-4 : 1e-7;
    const RandomFilter random(900 + seed, 1 + static_cast<int>(seed) / 10, slowest);
    Filter filter = difference_filter(0.5, random.differences);
    for (const auto& s : random.sections) filter.sections.push_back(section_in_w(s.b, s.a));
    expect_norms("random " + std::to_string(seed), filter);
  }
}

}  // namespace
}  // namespace qerr
