#include "diagnose/surrogates/residual_statistics.hpp"

#include <algorithm>

#include "core/parallel.hpp"
#include "diagnose/surrogates/residual_sums.hpp"

namespace qerr {

namespace {

/// Lanes per vector of the widest instruction set, so that the batches are the same for all sets, and vectors
/// per batch.
constexpr std::size_t lanes_per_vector = 8, vectors_per_batch = 4;

/// Statistics of `width` lanes from `first` on; lane 0 is the record itself.
std::vector<ResidualStatistic> run(const ResidualPlan& plan, std::uint64_t seed, std::size_t first,
                                   std::size_t width, InstructionSet set) {
  constexpr std::size_t most_rows = ResidualSums::most_rows;
  Surrogates surrogates(plan.surrogates, seed, first, width, set);
  ResidualSums sums(plan, width, set);
  const AlignedNumbers residual(most_rows * width), state(most_rows * width);
  std::size_t row = 0;
  for (const RowRange& range : plan.ranges) {
    surrogates.start();
    sums.start();
    for (const std::size_t end = row + static_cast<std::size_t>(range.rows); row < end;) {
      const std::size_t rows = std::min(most_rows, end - row);
      surrogates.read(row, rows, residual.data(), state.data());
      for (std::size_t k = 0; first == 0 && k < rows; ++k) {
        residual[k * width] = plan.residual[static_cast<Eigen::Index>(row + k)];
        state[k * width] = plan.state[static_cast<Eigen::Index>(row + k)];
      }
      sums.add(residual.data(), state.data(), rows);
      row += rows;
    }
  }
  return sums.statistics();
}

}  // namespace

std::vector<ResidualStatistic> residual_statistics(const Evidence& e, const std::vector<Filter>& filters,
                                                   Eigen::Index surrogates, std::uint64_t seed,
                                                   unsigned threads, InstructionSet set) {
  const ResidualPlan plan = residual_plan(e, filters, set);
  const Eigen::Index all = surrogates + 1;
  const std::size_t vectors = (static_cast<std::size_t>(all) + lanes_per_vector - 1) / lanes_per_vector;
  std::vector<std::vector<ResidualStatistic>> batches((vectors + vectors_per_batch - 1) / vectors_per_batch);
  parallel_for(batches.size(), threads, [&](std::size_t i) {
    const std::size_t first = i * vectors / batches.size(), end = (i + 1) * vectors / batches.size();
    batches[i] = run(plan, seed, first * lanes_per_vector, (end - first) * lanes_per_vector, set);
  });
  std::vector<ResidualStatistic> joined = batches.front();
  for (std::size_t s = 0; s < joined.size(); ++s) {
    Eigen::ArrayXd values(all);
    Eigen::Index next = 0;
    for (const auto& batch : batches) {
      const Eigen::Index lanes = std::min(all - next, batch[s].values.size());
      values.segment(next, lanes) = batch[s].values.head(lanes);
      next += lanes;
    }
    joined[s].values = std::move(values);
  }
  return joined;
}

}  // namespace qerr
