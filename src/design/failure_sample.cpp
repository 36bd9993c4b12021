#include <Eigen/Core>
#include <algorithm>
#include <numeric>

#include "core/statistics.hpp"
#include "design/choice_pool.hpp"

namespace qerr {

struct FailureSample::Values {
  std::vector<Eigen::ArrayXd> sums;
};

FailureSample::FailureSample(const ChoiceFigure& figure, std::size_t configurations)
    : figure_(&figure),
      permitted_(PercentileRank(figure.percentile, configurations).permitted(configurations)) {
  for (const WeightedSum& sum : figure.sums) columns_.emplace_back(sum.columns.size());
}

void FailureSample::add(const std::vector<std::uint32_t>& configurations) {
  std::vector<std::uint32_t> all;
  std::set_union(members_.begin(), members_.end(), configurations.begin(), configurations.end(),
                 std::back_inserter(all));
  if (all.size() == members_.size()) return;
  members_ = std::move(all);
  for (std::size_t s = 0; s < columns_.size(); ++s)
    for (std::size_t k = 0; k < columns_[s].size(); ++k) {
      columns_[s][k].clear();
      const double* const from = figure_->sums[s].columns[k].coefficients;
      for (const std::uint32_t i : members_) columns_[s][k].push_back(from[i]);
    }
}

bool FailureSample::fails(const Values& values, double limit) const {
  Eigen::ArrayXd largest = values.sums.front();
  for (std::size_t s = 1; s < values.sums.size(); ++s) largest = largest.max(values.sums[s]);
  return static_cast<std::size_t>((largest > limit).count()) > permitted_;
}

void FailureSample::restrict_joint(std::size_t joint, const Values& least, const SumWeights& weights,
                                   double limit, const std::vector<std::size_t>& offsets,
                                   PermittedOptions& permitted, double& work) const {
  std::vector<std::size_t> options;
  const WeightedColumn* only = nullptr;
  std::size_t columns = 0;
  for (const WeightedSum& sum : figure_->sums)
    for (const WeightedColumn& c : sum.columns)
      if (c.joint == joint) {
        only = &c;
        ++columns;
      }
  for (std::size_t o = offsets[joint]; o < offsets[joint + 1]; ++o)
    if (permitted[o]) options.push_back(o - offsets[joint]);
  if (!only || options.size() < 2) return;
  const auto fails_with = [&](std::size_t option) {
    Values values = least;
    for (std::size_t s = 0; s < columns_.size(); ++s)
      for (std::size_t k = 0; k < columns_[s].size(); ++k) {
        const WeightedColumn& c = figure_->sums[s].columns[k];
        const double more = c.joint == joint ? c.weights[option] - weights[s][k] : 0;
        if (more == 0) continue;
        values.sums[s] +=
            more * Eigen::Map<const Eigen::ArrayXd>(columns_[s][k].data(), static_cast<Eigen::Index>(size()));
      }
    work += 3 * static_cast<double>(size() * columns);
    return fails(values, limit);
  };
  if (columns > 1) {
    for (const std::size_t o : options)
      if (fails_with(o)) permitted[offsets[joint] + o] = 0;
    return;
  }
  // With one column, options that are coarser than one that fails fail as well.
  std::sort(options.begin(), options.end(),
            [&](std::size_t a, std::size_t b) { return only->weights[a] > only->weights[b]; });
  if (!fails_with(options.front())) return;
  const auto first_good = std::partition_point(options.begin() + 1, options.end(), fails_with);
  for (auto o = options.begin(); o != first_good; ++o) permitted[offsets[joint] + *o] = 0;
}

bool FailureSample::restrict(double limit, const std::vector<std::size_t>& offsets,
                             PermittedOptions& permitted, double& work) const {
  if (size() <= permitted_ || !(limit < std::numeric_limits<double>::infinity())) return true;
  limit *= 1 + 2 * figure_->tolerance;
  if (figure_->root) limit *= limit;
  const SumWeights weights = least_weights(*figure_, offsets, permitted);
  Values least;
  for (std::size_t s = 0; s < columns_.size(); ++s) {
    Eigen::ArrayXd& sum = least.sums.emplace_back(
        Eigen::ArrayXd::Constant(static_cast<Eigen::Index>(size()), figure_->sums[s].added));
    for (std::size_t k = 0; k < columns_[s].size(); ++k)
      if (weights[s][k] != 0)
        sum += weights[s][k] *
               Eigen::Map<const Eigen::ArrayXd>(columns_[s][k].data(), static_cast<Eigen::Index>(size()));
    work += static_cast<double>(size() * columns_[s].size());
  }
  if (fails(least, limit)) return false;
  for (std::size_t j = 0; j + 1 < offsets.size(); ++j)
    restrict_joint(j, least, weights, limit, offsets, permitted, work);
  return true;
}

}  // namespace qerr
