#include "residual_statistics.hpp"

#include <algorithm>

#include "qerr/core/parallel.hpp"
#include "residual_sums.hpp"

namespace qerr {

namespace {

constexpr Eigen::Index lanes_at_once = 25;

/// Lanes first .. first + lanes of all; lane 0 is the record itself.
std::vector<Statistic> run(const ResidualPlan& plan, std::uint64_t seed, Eigen::Index first,
                           Eigen::Index lanes) {
  Surrogate surrogate(*plan.e, seed, static_cast<std::uint64_t>(first), lanes);
  ResidualSums sums(plan, lanes);
  Eigen::ArrayXd residual(lanes);
  Eigen::ArrayXi state(lanes);
  for (const Stretch& s : plan.parts) {
    surrogate.start();
    sums.start();
    for (Eigen::Index k = s.first; k < s.first + s.rows; ++k) {
      surrogate.read(k, residual, state);
      if (first == 0) residual[0] = plan.residual[k], state[0] = plan.state[k];
      sums.add(residual, state);
    }
  }
  return sums.statistics();
}

}  // namespace

std::vector<Statistic> residual_statistics(const Evidence& e, const std::vector<Filter>& filters,
                                           Eigen::Index surrogates, std::uint64_t seed, unsigned threads) {
  const ResidualPlan plan = residual_plan(e, filters);
  const Eigen::Index all = surrogates + 1;
  std::vector<std::vector<Statistic>> batches(
      static_cast<std::size_t>((all + lanes_at_once - 1) / lanes_at_once));
  parallel_for(batches.size(), threads, [&](std::size_t i) {
    const Eigen::Index first = static_cast<Eigen::Index>(i) * lanes_at_once;
    batches[i] = run(plan, seed, first, std::min(lanes_at_once, all - first));
  });
  std::vector<Statistic> joined = batches.front();
  for (std::size_t s = 0; s < joined.size(); ++s) {
    Eigen::ArrayXd values(all);
    Eigen::Index at = 0;
    for (const auto& batch : batches) {
      values.segment(at, batch[s].values.size()) = batch[s].values;
      at += batch[s].values.size();
    }
    joined[s].values = std::move(values);
  }
  return joined;
}

}  // namespace qerr
