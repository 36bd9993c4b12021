#include "qerr_scalar.hpp"

#include "qerr/bound/workspace.hpp"
#include "tally.hpp"

namespace qerr::bench {

namespace {

using Figures = Eigen::Matrix<double, Tally::figures, 1>;

/// The figures of one configuration: worst cases, then sigmas.
Figures bounds(const Problem& p, const Eigen::VectorXd& q, Recording* recording, Eigen::Index column) {
  const OperationalError e = operational_error(p.model, q);
  const Eigen::MatrixXd sigma = covariance(e);
  observe(sigma.data());
  if (recording) {
    recording->worst_cases.col(column) = e.worst_case;
    int entry = 0;
    for (int row = 0; row < 6; ++row)
      for (int c = 0; c <= row; ++c) recording->covariances(entry++, column) = sigma(row, c);
  }
  return (Figures() << e.worst_case, e.sigma).finished();
}

Summaries scalar_run(const Problem& p, Stage stage, std::uint64_t count, Recording* recording) {
  Tally tally;
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    const Eigen::VectorXd q = p.points.col(column);
    if (recording || stage == Stage::jac) {
      const Jacobian j = jacobian(p.model.chain, q);
      observe(j.data());
      if (recording) recording->jacobians.col(column) = Eigen::Map<const Eigen::VectorXd>(j.data(), j.size());
    }
    if (stage == Stage::jac) continue;
    const Figures figures = bounds(p, q, recording, column);
    observe(figures.data());
    if (stage == Stage::full) tally.add(i, figures.data());
  }
  return stage == Stage::full ? tally.result(p.points) : Summaries{};
}

Summary summary(const Statistic& s) { return {s.max, s.mean, s.p50, s.p95, s.p99, s.at_max}; }

Summaries workspace_run(const Problem& p, std::uint64_t count) {
  Configurations configurations = p.configurations;
  configurations.count = count;
  const Workspace all = workspace(p.model, {}, configurations, {.threads = 1});
  Summaries result;
  for (const CoordinateStatistics& c : all.coordinates) result.push_back(summary(c.worst_case));
  for (const CoordinateStatistics& c : all.coordinates) result.push_back(summary(c.sigma));
  return result;
}

}  // namespace

Contestant qerr_scalar() {
  return {"qerr scalar", QERR_BUILT, [](const Problem& p) -> Run {
            return [&p](Stage stage, std::uint64_t count, Recording* r) {
              return scalar_run(p, stage, count, r);
            };
          }};
}

Contestant qerr_workspace() {
  return {.name = "qerr workspace",
          .built = QERR_BUILT,
          .prepare = [](const Problem& p) -> Run {
            return [&p](Stage, std::uint64_t count, Recording*) { return workspace_run(p, count); };
          },
          .whole_job_only = true,
          .draws_itself = true};
}

}  // namespace qerr::bench
