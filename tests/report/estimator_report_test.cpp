#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "qerr/report/filter_report.hpp"
#include "qerr/report/write.hpp"

namespace qerr {
namespace {

Spec spec() { return read_spec(std::string(QERR_SOURCE_DIR) + "/tests/corpus/good_specs/filters.yaml"); }

FilterReport report(std::optional<double> clock) {
  FilterQuestions q;
  q.estimators = true;
  q.clock = clock;
  return filter_report(spec(), q);
}

TEST(EstimatorReport, ComparesEveryEncoderAroundOneCountPerSample) {
  const Spec s = spec();
  const EstimatorReport r = estimator_report(s);
  ASSERT_EQ(r.encoders.size(), s.model.chain.independent.size());
  EXPECT_EQ(r.clock, r.sample_rate);
  for (const EncoderEstimators& e : r.encoders) {
    EXPECT_DOUBLE_EQ(e.crossing_speed, e.resolution * r.sample_rate) << e.encoder;
    EXPECT_LT(e.rows.front().speed, 0.1 * e.crossing_speed);
    EXPECT_GT(e.rows.back().speed, e.crossing_speed);
    for (const EstimatorRow& row : e.rows)
      EXPECT_EQ(row.inverse_time.varying <= row.finite_difference.varying, row.speed <= e.crossing_speed);
  }
}

TEST(EstimatorReport, ShowsBothSidesOfTheCrossingForAnyClock) {
  for (const double clock : {1e-3, 5., 999., 1e6, 1e15})
    for (const EncoderEstimators& e : estimator_report(spec(), clock).encoders) {
      EXPECT_LT(e.rows.front().speed, e.crossing_speed) << clock;
      EXPECT_GT(e.rows.back().speed, e.crossing_speed) << clock;
    }
}

TEST(EstimatorReport, HasTheSameFiguresInJsonAndCsv) {
  const FilterReport r = report(1e6);
  const auto json = nlohmann::json::parse(write(r, "json", {}));
  const std::string csv = write(r, "csv", {});
  std::size_t rows = 0;
  for (const auto& e : json.at("estimators")) {
    EXPECT_EQ(e.at("clock"), 1e6);
    for (const auto& at : e.at("speeds")) {
      const double speed = at.at("speed");
      for (const std::string estimator : {"finite_difference", "inverse_time"})
        for (const std::string bound : {"printed", "varying", "constant"}) {
          const auto& error = at.at(estimator).at(bound).at("error");
          const auto cell = [](const nlohmann::json& x) {
            return x.is_null() ? "" : shortest(x.get<double>());
          };
          const std::string row = e.at("encoder").get<std::string>() + ',' + shortest(speed) + ',' +
                                  e.at("unit").get<std::string>() + ',' + cell(at.at("quanta_per_sample")) +
                                  ',' + estimator + ',' + bound + ',' + cell(error) + ',';
          EXPECT_NE(csv.find(row), std::string::npos) << row;
          if (!error.is_null() && error > 0) {
            EXPECT_NEAR(at.at(estimator).at(bound).at("snr_db"), 20 * std::log10(speed / error.get<double>()),
                        1e-9);
          }
          ++rows;
        }
    }
  }
  EXPECT_GT(rows, 0u);
  EXPECT_EQ(static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n')), rows + 1);
}

TEST(EstimatorReport, IsInTheReportOnRequestOnly) {
  const FilterReport without = filter_report(spec(), {});
  EXPECT_FALSE(nlohmann::json::parse(write(without, "json", {})).contains("estimators"));
  EXPECT_EQ(write(without, "csv", {}).rfind("filter,", 0), 0u);
  EXPECT_EQ(write(without, "table", {}).find("ITM"), std::string::npos);
  EXPECT_NE(write(report({}), "table", {}).find("ITM is at least as good up to"), std::string::npos);
}

}  // namespace
}  // namespace qerr
