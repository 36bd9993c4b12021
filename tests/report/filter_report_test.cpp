#include "qerr/report/filter_report.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "qerr/report/write.hpp"

namespace qerr {
namespace {

class FilterReports : public ::testing::Test {
 protected:
  Spec spec = read_spec(QERR_SOURCE_DIR "/configs/planar_prr/spec.yaml");
};

TEST_F(FilterReports, GivesEveryEncoderItsNoiseAtASpeed) {
  FilterQuestions questions;
  questions.motions = {
      {false, 1, 0, true, false}, {false, 0.5, 0, false, false}, {true, 0.2, 3, false, true}};
  const FilterReport report = filter_report(spec, questions);
  ASSERT_EQ(report.noise.size(), spec.filters.size());
  for (std::size_t f = 0; f < report.noise.size(); ++f) {
    // One count per sample for all three encoders, 0.5 rad/s for the two revolute ones, 0.2 m at 3 Hz for the
    // rail.
    ASSERT_EQ(report.noise[f].rows.size(), 6u);
    for (const NoiseRow& row : report.noise[f].rows) {
      const auto& encoders = spec.model.transmission.encoders;
      const double resolution = row.encoder == "rail" ? encoders[0].resolution : encoders[1].resolution;
      EXPECT_NEAR(row.sigma_ipqn, spec.filters[f].norms.h2 * resolution / std::sqrt(12.0),
                  1e-9 * row.sigma_ipqn);
      if (row.motion.in_counts) {
        EXPECT_NEAR(*row.sigma, 0, 1e-6 * row.sigma_ipqn);
      }
      if (!row.motion.in_counts && !row.motion.sine) {
        EXPECT_NEAR(row.counts_per_sample, 0.5 / (resolution * spec.filters[f].filter.sample_rate), 1e-12);
      }
      if (row.motion.sine) {
        EXPECT_EQ(row.encoder, "rail");
      }
    }
  }
}

TEST_F(FilterReports, TheNoiseTransientTendsToTheNorm) {
  const std::string csv = transient_csv(spec);
  double last = 0, largest = 0;
  std::string filter;
  for (std::size_t at = csv.find('\n') + 1; at < csv.size(); at = csv.find('\n', at) + 1) {
    const std::string name = csv.substr(at, csv.find(',', at) - at);
    const double sigma = std::stod(csv.substr(csv.find(',', csv.find(',', at) + 1) + 1));
    if (name == filter) {
      EXPECT_GE(sigma, last);
    }
    filter = name;
    last = sigma;
    if (name == spec.filters[0].name) largest = sigma;
  }
  EXPECT_NEAR(largest / spec.filters[0].norms.h2, 1, 2e-3);
  EXPECT_LE(largest, spec.filters[0].norms.h2 * (1 + 1e-12));
}

TEST_F(FilterReports, CsvIsOneTable) {
  FilterQuestions questions;
  EXPECT_EQ(write(filter_report(spec, questions), "csv", {}).substr(0, 20), "filter,quantity,unit");
  questions.motions = {{false, 0.3, 0, true, false}};
  const std::string csv = write(filter_report(spec, questions), "csv", {});
  EXPECT_EQ(csv.substr(0, 21), "filter,encoder,motion");
  EXPECT_EQ(csv.find("quantity"), std::string::npos);
}

}  // namespace
}  // namespace qerr
