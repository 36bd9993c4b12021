#include "qerr_batched.hpp"

#include <algorithm>

#include "bound/batched_error.hpp"
#include "counted.hpp"
#include "kinematics/folded_chain.hpp"
#include "kinematics/sampler.hpp"
#include "lanes/batch.hpp"
#include "qerr/bound/workspace.hpp"

namespace qerr::bench {

namespace {

constexpr auto lanes = static_cast<Eigen::Index>(batch_size);
/// [figure or entry][configuration], the layout of the kernels' output.
using Batch = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, lanes, Eigen::RowMajor>>;

Batch batch_of(const AlignedNumbers& numbers) {
  return {numbers.data(), static_cast<Eigen::Index>(numbers.size()) / lanes, lanes};
}

class Batched {
 public:
  Batched(const Problem& p, InstructionSet set)
      : problem_(&p),
        set_(set),
        jacobian_(p.model.chain, set),
        errors_(p.model, {.rigorous = false, .shares = false, .covariance = true}, set),
        q_(p.model.chain.independent.size() * batch_size),
        columns_(6 * p.model.chain.joints.size() * batch_size),
        figures_(errors_.figures().count * batch_size) {}

  Summaries run(Stage stage, std::uint64_t count, Recording* recording) {
    if (stage == Stage::full && !recording) return whole_job(count);
    Configurations configurations = problem_->configurations;
    configurations.count = count;
    Sampler sampler(configurations, set_);
    for (std::uint64_t first = 0; first < count; first += batch_size) {
      sampler(first, q_.data());
      if (recording || stage == Stage::jac) jacobian_(q_.data(), columns_.data());
      if (stage != Stage::jac) errors_(q_.data(), figures_.data());
      observe(columns_.data());
      observe(figures_.data());
      if (recording) record(*recording, static_cast<Eigen::Index>(first), stage);
    }
    return stage == Stage::full ? whole_job(count) : Summaries{};
  }

 private:
  Summaries whole_job(std::uint64_t count) const {
    Configurations configurations = problem_->configurations;
    configurations.count = count;
    const Workspace w =
        workspace(problem_->model, {}, configurations, {.threads = 1, .brief = true, .instructions = set_});
    Summaries all;
    const auto add = [&](const Statistic& s) {
      all.push_back({s.max, s.mean, s.p50, s.p95, s.p99, s.at_max});
    };
    for (const CoordinateStatistics& c : w.coordinates) add(c.worst_case);
    for (const CoordinateStatistics& c : w.coordinates) add(c.sigma);
    return all;
  }

  void record(Recording& r, Eigen::Index first, Stage stage) const {
    const Eigen::Index count = std::min(lanes, r.jacobians.cols() - first);
    for (Eigen::Index c = 0; c < count; ++c) {
      const Eigen::VectorXd entries = batch_of(columns_).col(c);
      const Eigen::MatrixXd folded = entries.reshaped(6, problem_->fold.rows()) * problem_->fold;
      r.jacobians.col(first + c) = folded.reshaped();
      if (stage == Stage::jac) continue;
      const FigureLayout& at = errors_.figures();
      const Eigen::VectorXd figures = batch_of(figures_).col(c);
      r.worst_cases.col(first + c) = figures.segment(static_cast<Eigen::Index>(at.worst_case), 6);
      r.covariances.col(first + c) =
          figures.segment(static_cast<Eigen::Index>(at.covariance), covariance_entries);
    }
  }

  const Problem* problem_;
  InstructionSet set_;
  BatchedJacobian jacobian_;
  BatchedError errors_;
  AlignedNumbers q_, columns_, figures_;
};

}  // namespace

/// Operations of a configuration including its sampling: a multiplication for each joint.
double counted_operations(const Problem& p, Stage stage) {
  const auto drawn = static_cast<double>(p.model.chain.independent.size());
  const AlignedNumbers q(p.model.chain.independent.size() * batch_size), figures(64 * batch_size), sums(64);
  const AlignedNumbers room(64 * (p.model.chain.joints.size() + 1));
  for (std::size_t i = 0; i < q.size(); ++i) q[i] = 0.1 * static_cast<double>(i % 17);
  if (stage == Stage::jac) {
    const FoldedChain chain = fold(p.model.chain, false);
    const std::vector<double> signs(chain.joints.size(), 1.0);
    return drawn + multiplications(path_of(chain), signs.data(), q.data(), room.data());
  }
  const PlannedError planned(p.model, {.rigorous = false, .shares = false, .covariance = true});
  return drawn + multiplications(planned.plan(), q.data(), figures.data(), sums.data(), room.data());
}

std::vector<Contestant> qerr_batched() {
  std::vector<Contestant> rows;
  for (const InstructionSet set : available_instruction_sets())
    rows.push_back({.name = "qerr " + std::string(name_of(set)),
                    .built = QERR_BUILT,
                    .prepare = [set](const Problem& p) -> Run {
                      const auto batched = std::make_shared<Batched>(p, set);
                      return [batched](Stage stage, std::uint64_t count, Recording* r) {
                        return batched->run(stage, count, r);
                      };
                    },
                    .draws_itself = true,
                    .instruction_set = std::string(name_of(set)),
                    .fma_pipe_operations = counted_operations});
  return rows;
}

}  // namespace qerr::bench
