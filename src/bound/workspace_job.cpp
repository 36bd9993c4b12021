#include "workspace_job.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "qerr/core/parallel.hpp"
#include "qerr/core/random.hpp"

namespace qerr {

WorkspaceJob::WorkspaceJob(const OperationalModel& model, const std::vector<Norms>& filters,
                           const Configurations& configurations, const WorkspaceOptions& options)
    : joints_(model.chain.independent.size()),
      total_(size(configurations)),
      options_(options),
      kernels_(bound_kernels(options.instructions)),
      sampler_(configurations, options.instructions),
      errors_(model,
              {.rigorous = !options.brief,
               .shares = !options.brief,
               .roots = false,
               .filters = filters,
               .noise_in_motion = options.noise_in_motion},
              options.instructions),
      exact_(total_ <= exact_percentiles_limit),
      joined_(errors_.figures().count),
      largest_(joined_.size(), -1.0),
      sums_(errors_.sums().count) {
  if (exact_)
    values_ = AlignedNumbers(joined_.size() * total_);
  else
    look_around();
}

void WorkspaceJob::run() {
  const unsigned threads = thread_count(options_.threads);
  std::vector<Worker> workers;
  for (unsigned i = 0; i < std::min<std::uint64_t>(threads, blocks()); ++i) workers.push_back(worker());
  // What all blocks of a wave find is known to those of the next: the first waves are short. Texts wait in
  // memory for their turn.
  const std::uint64_t most = options_.text ? 16 : 256;
  std::vector<BlockResult> results;
  for (std::uint64_t wave = 0, size = 16; wave < blocks(); wave += size, size = std::min(2 * size, most)) {
    results.resize(std::min(size, blocks() - wave));
    std::atomic<std::size_t> next{0};
    parallel_for(workers.size(), threads, [&](std::size_t i) {
      for (std::size_t b = next++; b < results.size(); b = next++)
        block(workers[i], (wave + b) * block_size, results[b]);
    });
    for (const BlockResult& result : results) join(result);
    for (std::size_t f = 0; f < joined_.size(); ++f) largest_[f] = std::max(largest_[f], joined_[f].max());
    if (options_.progress) options_.progress(std::min(total_, (wave + results.size()) * block_size), total_);
  }
  for (Worker& worker : workers) {
    std::vector<Histogram> histograms = worker.counts.finish();
    if (histograms_.empty())
      histograms_ = std::move(histograms);
    else
      for (std::size_t f = 0; f < histograms.size(); ++f) histograms_[f].append(histograms[f]);
  }
}

Statistic WorkspaceJob::statistic_of(std::size_t figure) const {
  const JoinedTally& tally = joined_[figure];
  if (exact_) return statistic(tally, order_statistics(values_.data() + figure * total_, total_));
  return statistic(tally, [&](std::uint64_t rank) {
    return histograms_[figure].order_statistic(rank, tally.min(), tally.max());
  });
}

WorkspaceJob::Worker WorkspaceJob::worker() const {
  return {sampler_, errors_, AlignedNumbers(joints_ * batch_size),
          AlignedNumbers(joined_.size() * batch_size), DeferredCounts(lowest_bins_)};
}

TallyPlan WorkspaceJob::tally_plan() const {
  const FigureLayout& at = errors_.figures();
  return {at.count, at.sigma, at.coordinates, nullptr, nullptr, 0, {}};
}

/// Looks at some batches from all over the job before it starts: every thread bins alike, by the size of what
/// they show, and what is clearly smaller than their largest is no news to any.
void WorkspaceJob::look_around() {
  constexpr std::uint64_t looks = 64;
  constexpr double clearly_smaller = 1 - 1e-6;
  Worker w = worker();
  std::vector<double> typical(joined_.size());
  for (std::uint64_t look = 0; look < looks; ++look) {
    w.sampler(random_bits(look, 0, 0) % (total_ / batch_size) * batch_size, w.q.data());
    w.errors(w.q.data(), w.figures.data());
    kernels_.tally(tally_plan(), w.figures.data(), 0, std::vector<Tally>(joined_.size()).data());
    for (std::size_t f = 0; f < joined_.size(); ++f)
      for (std::size_t i = 0; i < batch_size; ++i)
        if (const double value = w.figures[f * batch_size + i]; std::isfinite(value))
          typical[f] = std::max(typical[f], value);
  }
  for (std::size_t f = 0; f < joined_.size(); ++f) {
    lowest_bins_.push_back(Histogram::lowest_bin(typical[f]));
    if (typical[f] > 0) largest_[f] = clearly_smaller * typical[f];
  }
}

void WorkspaceJob::block(Worker& w, std::uint64_t first, BlockResult& result) {
  result.count = std::min(block_size, total_ - first);
  result.tallies.assign(joined_.size(), Tally{});
  result.text.clear();
  // What is not larger than what was found before is no news.
  for (std::size_t f = 0; f < joined_.size(); ++f) result.tallies[f].max = largest_[f];
  std::vector<double> surplus(errors_.sums().count);
  for (std::uint64_t done = 0; done < result.count; done += batch_size) {
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(batch_size, result.count - done));
    w.sampler(first + done, w.q.data());
    if (count < batch_size) surplus = fill_up(w, count);
    w.errors(w.q.data(), w.figures.data());
    keep(w, first + done, count, done / batch_size, result.tallies);
    if (options_.text)
      result.text += options_.text({first + done, count, w.q.data(), w.figures.data(), errors_.figures()});
  }
  w.counts.end_of_block(result.count);
  result.sums = w.errors.take_sums();
  for (std::size_t s = 0; s < result.sums.size(); ++s)
    if (s < errors_.sums().arms && std::isfinite(result.sums[s])) result.sums[s] -= surplus[s];
}

/// The last batch may be a part of one: the rest is filled with its first configuration, whose surplus in the
/// sums is found by a batch of nothing else. A sum without bound has no surplus that could be taken off.
std::vector<double> WorkspaceJob::fill_up(Worker& w, std::size_t count) const {
  BatchedError alone(w.errors);
  AlignedNumbers q(w.q.size()), figures(w.figures.size());
  for (std::size_t j = 0; j < joints_; ++j)
    for (std::size_t i = 0; i < batch_size; ++i) {
      q[j * batch_size + i] = w.q[j * batch_size];
      if (i >= count) w.q[j * batch_size + i] = w.q[j * batch_size];
    }
  alone(q.data(), figures.data());
  std::vector<double> surplus = alone.take_sums();
  for (double& sum : surplus) sum *= static_cast<double>(batch_size - count) / batch_size;
  return surplus;
}

/// @param batch  number of the batch in its block
void WorkspaceJob::keep(Worker& w, std::uint64_t first, std::size_t count, std::size_t batch,
                        std::vector<Tally>& tallies) {
  TallyPlan plan = tally_plan();
  if (!exact_) w.counts.plan(batch, plan);
  double* const figures = w.figures.data();
  if (count == batch_size) {
    kernels_.tally(plan, figures, first, tallies.data());
  } else {  // the rest of the batch is no configuration
    std::vector<Tally> of_all(tallies.size());
    kernels_.tally(plan, figures, first, of_all.data());
    for (std::size_t f = 0; f < tallies.size(); ++f)
      tally_some(figures + f * batch_size, count, first, tallies[f]);
  }
  if (!exact_) return;
  for (std::size_t f = 0; f < tallies.size(); ++f)
    std::copy_n(figures + f * batch_size, count, &values_[f * total_ + first]);
}

void WorkspaceJob::join(const BlockResult& block) {
  for (std::size_t f = 0; f < joined_.size(); ++f) joined_[f].append(block.tallies[f], block.count);
  for (std::size_t s = 0; s < sums_.size(); ++s)
    sums_[s] =
        s < errors_.sums().arms ? sums_[s] + block.sums[s] : std::max<long double>(sums_[s], block.sums[s]);
  if (options_.write) options_.write(block.text);
}

}  // namespace qerr
