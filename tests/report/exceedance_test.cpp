#include <gtest/gtest.h>

#include "input/read_sections.hpp"
#include "qerr/core/error.hpp"
#include "report/analysis/figures.hpp"

namespace qerr {
namespace {

Spec spec_with(const SpecOverrides& changes) {
  return read_spec(QERR_SOURCE_DIR "/configs/kuka_lwr/spec.yaml", changes);
}

std::vector<Exceedance> counted(Spec spec, const std::vector<std::string>& limits, unsigned threads = 1) {
  ExceedanceCounter counter(spec, read_limits("--above", limits, spec));
  WorkspaceOptions options;
  options.threads = threads;
  options.visit = counter.visitor();
  return counter.result(analyze(spec, options));
}

TEST(Exceedance, CountsTheConfigurationsOneByOne) {
  const Spec spec = spec_with({{{"configurations", "{count: 777}"}, {"coordinates", "[x, z]"}}, {}});
  const double limit = analyze(spec).workspace.coordinates[1].worst_case.p95;
  const auto found = counted(spec, {"position.z.worst_case=" + std::to_string(1e6 * limit) + " um"});
  ASSERT_EQ(found.size(), 1u);
  std::uint64_t above = 0;
  Eigen::Vector3d lowest = Eigen::Vector3d::Constant(1e9);
  std::vector<std::uint64_t> shells(found[0].by_distance.size());
  for (Eigen::Index i = 0; i < 777; ++i) {
    const Eigen::VectorXd q = draw(spec.configurations, static_cast<std::uint64_t>(i), 1).col(0);
    const Eigen::Vector3d tip = forward_kinematics(spec.model.chain, q).translation();
    const double step = found[0].by_distance[0].to;
    ++shells.at(static_cast<std::size_t>(tip.norm() / step));
    if (!(operational_error(spec.model, q).worst_case[1] > found[0].limit)) continue;
    ++above;
    lowest = lowest.cwiseMin(tip);
  }
  EXPECT_EQ(found[0].count, 777u);
  EXPECT_EQ(found[0].above, above);
  EXPECT_NEAR(static_cast<double>(above), 0.05 * 777, 1.5);
  EXPECT_LT((found[0].lowest - lowest).norm(), 1e-12);
  std::uint64_t sum = 0;
  for (std::size_t s = 0; s < shells.size(); ++s) {
    EXPECT_EQ(found[0].by_distance[s].count, shells[s]);
    sum += found[0].by_distance[s].above;
  }
  EXPECT_EQ(sum, above);
}

TEST(Exceedance, IsTheSameForAnyNumberOfThreads) {
  const Spec spec = spec_with({{{"configurations", "{count: 20000}"}}, {}});
  const std::vector<std::string> limits{"position.xyz.worst_case=50 um", "velocity.x.sigma=1 mm/s"};
  const auto one = counted(spec, limits, 1), three = counted(spec, limits, 3);
  for (std::size_t l = 0; l < limits.size(); ++l) {
    EXPECT_EQ(one[l].above, three[l].above);
    EXPECT_EQ(one[l].lowest, three[l].lowest);
    EXPECT_EQ(one[l].highest, three[l].highest);
    for (std::size_t s = 0; s < one[l].by_distance.size(); ++s)
      EXPECT_EQ(one[l].by_distance[s].above, three[l].by_distance[s].above);
  }
}

TEST(Exceedance, BehindAFilterAgreesWithTheStatistics) {
  const Spec spec = spec_with({{{"configurations", "{count: 5000}"}}, {}});
  const Workspace w = analyze(spec).workspace;
  const auto text = [](const char* quantity, double limit) {
    return quantity + ('=' + std::to_string(1e6 * limit)) + " um/s";
  };
  const auto found =
      counted(spec, {text("velocity.y.sigma", w.derivatives[0][1].sigma->p50),
                     text("velocity.y.worst_case", w.derivatives[0][1].worst_case.max * 1.001),
                     text("velocity.y.worst_case", w.derivatives[0][1].worst_case.min * 0.999)});
  EXPECT_NEAR(static_cast<double>(found[0].above), 2500, 5);
  EXPECT_EQ(found[1].above, 0u);
  EXPECT_EQ(found[2].above, 5000u);
}

TEST(Exceedance, RefusesWhatIsNoBoundOfACoordinate) {
  Spec spec = spec_with({});
  for (const char* text : {"position.x.worst_case", "=1 mm", "position.q.sigma=1 mm", "velocity.delay=1 ms",
                           "position.x.sigma=1 s", "position.x.sigma=soon"})
    try {
      read_limits("--above", {text}, spec);
      ADD_FAILURE() << text;
    } catch (const Error& e) {
      EXPECT_EQ(e.trouble(), Trouble::usage) << text;
      EXPECT_NE(std::string(e.what()).find("--above"), std::string::npos) << e.what();
    }
}

}  // namespace
}  // namespace qerr
