#include "report/analysis/exceedance.hpp"

#include <algorithm>

#include "bound/figure_column.hpp"
#include "core/text.hpp"
#include "qerr/core/error.hpp"
#include "report/analysis/figure_names.hpp"
#include "report/text_picture.hpp"

namespace qerr {

ExceedanceCounter::ExceedanceCounter(const Spec& spec, std::vector<Requirement> limits)
    : chain_(spec.model.chain), filters_(filter_norms(spec)), limits_(std::move(limits)) {
  constexpr double most_shells = 10;  // that fit on a terminal beside the other tables
  const double farthest = reach(chain_, spec.configurations);
  step_ = farthest > 0 ? round_step(farthest / most_shells) : 1;
  Exceedance empty;
  for (double from = 0; from == 0 || from < farthest * (1 - 1e-9); from += step_)
    empty.by_distance.push_back({from, from + step_, 0, 0});
  for (const Requirement& r : limits_) {
    figures_.push_back(proven_figure(r, spec.model));
    Exceedance& e = counts_.emplace_back(empty);
    e.quantity = r.quantity;
    e.limit = r.limit;
    e.unit = r.unit;
  }
}

void ExceedanceCounter::count(const ConfigurationBatch& batch) {
  std::vector<Eigen::Vector3d> tips;
  for (std::size_t i = 0; i < batch.count; ++i)
    tips.push_back(forward_kinematics(chain_, configuration_of(batch, i, chain_)).translation());
  const std::lock_guard lock(guard_);
  for (std::size_t l = 0; l < limits_.size(); ++l) {
    const auto [figure, factor] = figure_column(figures_[l], filters_, batch.layout);
    for (std::size_t i = 0; i < batch.count; ++i)
      add(counts_[l], tips[i], factor * batch.figures[figure * batch_size + i] > limits_[l].limit);
  }
}

void ExceedanceCounter::add(Exceedance& e, const Eigen::Vector3d& tip, bool above) const {
  const auto shell = std::min(static_cast<std::size_t>(tip.norm() / step_), e.by_distance.size() - 1);
  ++e.count;
  ++e.by_distance[shell].count;
  if (!above) return;
  ++e.above;
  ++e.by_distance[shell].above;
  e.lowest = e.lowest.cwiseMin(tip);
  e.highest = e.highest.cwiseMax(tip);
}

std::vector<Exceedance> ExceedanceCounter::result(const Analysis& a) const {
  for (const Requirement& r : limits_)
    if (!statistic_of(a.workspace, r) && r.bound != Bound::sigma_quantization)
      throw Error({{},
                   "--above",
                   "the bound is not known at the configurations",
                   quoted(r.quantity),
                   "the warnings of `qerr analyze` without the option say why; name another bound"},
                  Trouble::usage);
  return counts_;
}

}  // namespace qerr
