#include "report/analysis/exceedance.hpp"

#include <algorithm>
#include <mutex>

#include "bound/figure_column.hpp"
#include "core/text.hpp"
#include "qerr/core/error.hpp"
#include "report/analysis/figure_names.hpp"
#include "report/text_picture.hpp"

namespace qerr {

namespace {

constexpr double most_shells = 10;  // that fit on a terminal beside the other tables

}  // namespace

struct ExceedanceCounter::Job {
  Chain chain;
  std::vector<Norms> filters;
  std::vector<Requirement> limits;
  std::vector<Figure> figures;  // of the limits
  double step;
  std::mutex guard;
  std::vector<Exceedance> counts;  // [limit]; sums and extremes do not depend on the order of the batches

  void count(const ConfigurationBatch& batch) {
    std::vector<Eigen::Vector3d> tips;
    for (std::size_t i = 0; i < batch.count; ++i)
      tips.push_back(forward_kinematics(chain, configuration_of(batch, i, chain)).translation());
    const std::lock_guard lock(guard);
    for (std::size_t l = 0; l < limits.size(); ++l) {
      const auto [figure, factor] = figure_column(figures[l], filters, batch.layout);
      for (std::size_t i = 0; i < batch.count; ++i)
        add(counts[l], tips[i], factor * batch.figures[figure * batch_size + i] > limits[l].limit);
    }
  }

  void add(Exceedance& e, const Eigen::Vector3d& tip, bool above) const {
    const auto shell = std::min(static_cast<std::size_t>(tip.norm() / step), e.by_distance.size() - 1);
    ++e.count;
    ++e.by_distance[shell].count;
    if (!above) return;
    ++e.above;
    ++e.by_distance[shell].above;
    e.lowest = e.lowest.cwiseMin(tip);
    e.highest = e.highest.cwiseMax(tip);
  }
};

ExceedanceCounter::ExceedanceCounter(const Spec& spec, std::vector<Requirement> limits) {
  const double farthest = reach(spec.model.chain, spec.configurations);
  const double step = farthest > 0 ? round_step(farthest / most_shells) : 1;
  Exceedance empty;
  for (double from = 0; from == 0 || from < farthest * (1 - 1e-9); from += step)
    empty.by_distance.push_back({from, from + step, 0, 0});
  job_ = std::make_unique<Job>();
  job_->chain = spec.model.chain;
  job_->filters = filter_norms(spec);
  job_->step = step;
  for (const Requirement& r : limits) {
    job_->counts.push_back(empty);
    job_->figures.push_back(proven_figure(r, spec.model));
    job_->counts.back().quantity = r.quantity;
    job_->counts.back().limit = r.limit;
    job_->counts.back().unit = r.unit;
  }
  job_->limits = std::move(limits);
}

ExceedanceCounter::~ExceedanceCounter() = default;

std::function<void(const ConfigurationBatch&)> ExceedanceCounter::visitor() {
  return [this](const ConfigurationBatch& batch) { job_->count(batch); };
}

std::vector<Exceedance> ExceedanceCounter::result(const Analysis& a) const {
  for (const Requirement& r : job_->limits)
    if (!statistic_of(a.workspace, r) && r.bound != Bound::sigma_quantization)
      throw Error({{},
                   "--above",
                   "the bound is not known at the configurations",
                   quoted(r.quantity),
                   "the warnings of `qerr analyze` without the option say why; name another bound"},
                  Trouble::usage);
  return job_->counts;
}

}  // namespace qerr
