#include "report/analysis/page/sample.hpp"

#include <algorithm>

#include "bound/figure_column.hpp"
#include "core/parallel.hpp"
#include "core/random.hpp"
#include "qerr/kinematics/coordinates.hpp"
#include "report/analysis/figure_names.hpp"

namespace qerr {

namespace {

Configurations reduced(const Configurations& all) {
  const std::uint64_t count = size(all);
  if (count <= most_sampled) return all;
  Configurations some = all;
  if (all.method == SamplingMethod::sobol || all.method == SamplingMethod::random) {
    some.count = most_sampled;
    return some;
  }
  some.method = SamplingMethod::list;
  some.points.clear();
  const double part = static_cast<double>(count) / most_sampled;
  for (std::uint64_t i = 0; i < most_sampled; ++i) {
    const double at = part * (static_cast<double>(i) + unit_interval(stream_seed(all.seed, "page", i)));
    some.points.emplace_back(draw(all, std::min(static_cast<std::uint64_t>(at), count - 1), 1).col(0));
  }
  return some;
}

/// Receives batches from any thread; each writes to places of its own.
class SampleCollector {
 public:
  SampleCollector(const Analysis& a, std::size_t count) : a_(a), filters_(filter_norms(a.spec)) {
    for_each_figure(a, [&](const FigureName& name, const Statistic&) { figures_.push_back(name.figure); });
    sample_.of = a.workspace.count;
    sample_.q.resize(count);
    sample_.tips.resize(count);
    sample_.trace.resize(count);
    sample_.worst.assign(a.workspace.coordinates.size(), std::vector<double>(count));
    sample_.distributions.assign(figures_.size(), std::vector<double>(count));
  }

  void add(const ConfigurationBatch& batch) {
    const Chain& chain = a_.spec.model.chain;
    std::vector<FigureColumn> columns;
    for (const Figure& f : figures_) columns.push_back(figure_column(f, filters_, batch.layout));
    for (std::size_t i = 0; i < batch.count; ++i) {
      const std::size_t to = static_cast<std::size_t>(batch.first) + i;
      const auto figure = [&](std::size_t f) { return batch.figures[f * batch_size + i]; };
      Eigen::VectorXd q(static_cast<Eigen::Index>(chain.independent.size()));
      for (Eigen::Index j = 0; j < q.size(); ++j)
        q[j] = batch.q[static_cast<std::size_t>(j) * batch_size + i];
      sample_.tips[to] = forward_kinematics(chain, q).translation();
      sample_.q[to] = std::move(q);
      sample_.trace[to] = figure(batch.layout.trace);
      for (std::size_t c = 0; c < sample_.worst.size(); ++c)
        sample_.worst[c][to] = figure(batch.layout.worst_case + c);
      for (std::size_t f = 0; f < columns.size(); ++f)
        sample_.distributions[f][to] = columns[f].factor * figure(columns[f].figure);
    }
  }

  ConfigurationSample sorted() {
    parallel_for(sample_.distributions.size(), 0, [&](std::size_t f) {
      std::sort(sample_.distributions[f].begin(), sample_.distributions[f].end());
    });
    return std::move(sample_);
  }

 private:
  const Analysis& a_;
  std::vector<Norms> filters_;
  std::vector<Figure> figures_;
  ConfigurationSample sample_;
};

}  // namespace

ConfigurationSample configuration_sample(const Analysis& a) {
  const Configurations some = reduced(a.spec.configurations);
  const auto count = static_cast<std::size_t>(size(some));
  SampleCollector collector(a, count);
  WorkspaceOptions options;
  options.noise_in_motion = a.noise_in_motion;
  options.visit = [&](const ConfigurationBatch& batch) { collector.add(batch); };
  workspace(a.spec.model, filter_norms(a.spec), some, options);
  return collector.sorted();
}

std::string sampled_note(const ConfigurationSample& s) {
  return s.complete() ? "" : ", drawn from " + std::to_string(s.q.size()) + " of them";
}

}  // namespace qerr
