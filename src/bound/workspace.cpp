#include "qerr/bound/workspace.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <utility>

#include "bound/batched_error.hpp"
#include "bound/workspace_job.hpp"
#include "core/parallel.hpp"
#include "core/random.hpp"
#include "lanes/lanes.hpp"
#include "qerr/core/error.hpp"
#include "qerr/core/quantity.hpp"

namespace qerr {
BlockCounts::BlockCounts(std::vector<Histogram> empty)
    : histograms_(std::move(empty)),
      bins_(std::make_unique_for_overwrite<std::int32_t[]>(histograms_.size() * (block_size + batch_size))),
      lists_(histograms_.size()) {
  for (std::size_t f = 0; f < lists_.size(); ++f) {
    lists_[f].counted = histograms_[f].counted();
    lists_[f].next = list(f);
  }
}

void BlockCounts::end_of_block(std::uint64_t values) {
  for (std::size_t f = 0; f < lists_.size(); ++f) {
    BinList& bins = lists_[f];
    const auto listed = static_cast<std::size_t>(bins.next - list(f));
    std::uint64_t below = 0;
    for (std::int32_t& lane : bins.below) below += static_cast<std::uint64_t>(std::exchange(lane, 0));
    histograms_[f].add(list(f), listed, below, values - listed - below);
    bins.next = list(f);
  }
}

SampledBins::SampledBins(const std::int32_t* begin, const std::int32_t* end)
    : count_(static_cast<std::uint64_t>(end - begin)) {
  const std::int32_t infinite = leading_bits(std::numeric_limits<double>::infinity());
  std::int32_t smallest = infinite, beyond = CountedBins::first;
  for (const std::int32_t* bin = begin; bin != end; ++bin) {
    smallest = std::min(smallest, *bin);
    if (*bin < infinite) beyond = std::max(beyond, *bin + 1);
  }
  if (smallest == infinite) beyond = infinite;  // all values are infinite
  first_ = std::max(smallest, beyond - static_cast<std::int32_t>(bin_count));
  counts_.resize(beyond - first_ + 1);
  for (const std::int32_t* bin = begin; bin != end; ++bin)
    ++counts_[std::clamp(*bin, first_, beyond) - first_];
}

std::int32_t SampledBins::operator[](std::uint64_t rank) const {
  std::size_t bin = 0;
  for (std::uint64_t before = counts_[0]; before <= rank; before += counts_[bin]) ++bin;
  return first_ + static_cast<std::int32_t>(bin);
}

CountedBins SampledBins::near_percentiles() const {
  constexpr double deviations = 4.5;  // P(beyond) = 3.4e-6
  const auto n = static_cast<double>(count_);
  const auto edge = [&](double fraction, double side) {
    const double distance = deviations * std::sqrt(n * fraction * (1 - fraction));
    return (*this)[static_cast<std::uint64_t>(std::clamp(n * fraction + side * distance, 0.0, n - 1))];
  };
  // The first bin includes all smaller values.
  const auto from = [&](std::int32_t bin) { return bin == first_ ? CountedBins::first : bin; };
  std::vector<double> fractions;
  for (const StatisticKind& kind : statistic_kinds())
    if (kind.percentile >= 0) fractions.push_back(kind.percentile);
  std::ranges::sort(fractions);
  const double lowest = fractions.front(), next = fractions[fractions.size() > 1];
  return {from(edge(lowest, -1)), edge(lowest, 1) + 1, from(edge(next, -1))};
}

Histogram::Usual SampledBins::usual() const {
  constexpr std::int32_t octave = 1 << (52 - bin_shift);
  return {first_, static_cast<std::int32_t>(counts_.size()) + octave};
}

namespace {

/// Values smaller by this factor differ by more than rounding.
constexpr double clearly_smaller = 1 - 1e-6;

/// Largest |coordinate| of an independent joint over the configurations [rad or m].
double largest_coordinate(const Configurations& c, std::size_t joint) {
  if (c.method != SamplingMethod::list)
    return std::max(std::abs(c.ranges[joint].lower), std::abs(c.ranges[joint].upper));
  double largest = 0;
  for (const Eigen::VectorXd& point : c.points) largest = std::max(largest, std::abs(point[joint]));
  return largest;
}

/// Larger angles would lose accuracy (lanes.hpp).
void require_moderate_angles(const Chain& chain, const Configurations& c) {
  for (const ChainJoint& joint : chain.joints) {
    if (joint.prismatic) continue;
    const double angle =
        std::abs(joint.multiplier) * largest_coordinate(c, joint.coordinate) + std::abs(joint.offset);
    if (!(angle <= lanes::largest_angle))
      throw Error("configurations",
                  "joint '" + joint.name + "' must stay within 2^20 rad, about 167 000 revolutions",
                  shortest(angle) + " rad", "subtract whole revolutions");
  }
}

/// Converts the results of a job to a Workspace.
class Summary {
 public:
  Summary(const WorkspaceJob& job, const OperationalModel& model, const std::vector<Norms>& filters,
          const Configurations& configurations, const WorkspaceOptions& options)
      : job_(job),
        model_(model),
        filters_(filters),
        configurations_(configurations),
        options_(options),
        figures_(job.errors().figures()),
        sums_(job.errors().sums()),
        m_(model.coordinates.size()),
        encoders_(model.transmission.encoders.size()) {}

  Workspace workspace() const {
    Workspace w;
    w.count = job_.total();
    w.exact_percentiles = job_.exact();
    for (std::size_t c = 0; c < figures_.coordinates; ++c) w.coordinates.push_back(coordinate(c));
    for (std::size_t f = 0; f < filters_.size(); ++f) w.derivatives.push_back(derivatives(f, w));
    w.mean_covariance = covariance(sums_.covariance);
    if (!options_.brief) add_details(w);
    if (sums_.pitch < sums_.count) w.smallest_cosine_of_pitch = 1 - job_.maximum(sums_.pitch);
    return w;
  }

 private:
  Statistic statistic(std::size_t figure) const {
    Statistic s = job_.statistic_of(figure);
    if (job_.total() > 0) s.at_max = draw(configurations_, job_.at_max(figure), 1).col(0);
    return s;
  }

  CoordinateStatistics coordinate(std::size_t c) const {
    CoordinateStatistics s{statistic(figures_.worst_case + c), {}, statistic(figures_.sigma + c), {}, {}};
    if (options_.brief) return s;
    s.worst_case_rigorous = statistic(figures_.rigorous + c);
    if (c >= m_) return s;  // without sums
    s.share = above(1e-24, matrix(sums_.share).row(c));
    s.share_worst_case = above(1e-12, matrix(sums_.worst_share).row(c));
    return s;
  }

  /// Shares that are only rounding errors of trigonometry (zeros are about 1e-17) become 0.
  static Eigen::VectorXd above(double rounding, const Eigen::VectorXd& shares) {
    return (shares.array() > rounding).select(shares, 0.0);
  }

  std::vector<DerivativeStatistics> derivatives(std::size_t f, const Workspace& w) const {
    std::vector<DerivativeStatistics> all;
    for (std::size_t c = 0; c < figures_.coordinates; ++c) {
      const std::size_t figure = f * figures_.coordinates + c;
      all.push_back({job_.errors().own_worst_case()
                         ? statistic(figures_.filtered_worst + figure)
                         : scaled(w.coordinates[c].worst_case, filters_[f].l1.upper),
                     {},
                     {},
                     {}});
      if (!sigma_is_known(model_.sources, f)) continue;
      all.back().sigma = job_.errors().own_sigma() ? statistic(figures_.filtered_sigma + figure)
                                                   : scaled(w.coordinates[c].sigma, filters_[f].h2);
      if (is_known(options_.noise_in_motion, f))
        all.back().sigma_in_motion = statistic(figures_.in_motion + figure);
    }
    return all;
  }

  void add_details(Workspace& w) const {
    w.mean_variance_parts = matrix(sums_.variance_parts);
    w.mean_quantization_parts =
        job_.errors().has_sources() ? matrix(sums_.quantization_parts) : w.mean_variance_parts;
    w.largest_arms.resize(encoders_);
    for (std::size_t i = 0; i < encoders_; ++i) w.largest_arms[i] = job_.maximum(sums_.arms + i);
    if (job_.total() == 0) return;
    w.largest_at = draw(configurations_, job_.at_max(figures_.trace), 1).col(0);
    const OperationalError largest = operational_error(model_, w.largest_at);
    w.covariance_at_largest = qerr::covariance(largest);
    for (std::size_t f = 0; f < filters_.size() && job_.errors().own_sigma(); ++f) {
      auto& behind = w.filtered.emplace_back();
      if (!sigma_is_known(model_.sources, f)) continue;
      behind = {covariance(sums_.filtered + f * m_ * (m_ + 1) / 2),
                qerr::covariance(largest, filters_[f].h2, sigma_ratios(model_.sources, f, filters_[f].h2))};
    }
    if (!model_.along_motion) return;
    const auto add = [](const SignalMoments& signal, Eigen::MatrixXd& mean, Eigen::MatrixXd& at_largest) {
      mean += signal.covariance.topLeftCorner(mean.rows(), mean.cols());
      at_largest += signal.covariance.topLeftCorner(mean.rows(), mean.cols());
    };
    add(model_.along_motion->tip, w.mean_covariance, w.covariance_at_largest);
    for (std::size_t f = 0; f < w.filtered.size(); ++f)
      if (w.filtered[f].mean_covariance.size() > 0)
        add(model_.along_motion->filtered[f], w.filtered[f].mean_covariance,
            w.filtered[f].covariance_at_largest);
  }

  /// Coordinates x encoders.
  Eigen::MatrixXd matrix(std::size_t sum) const {
    Eigen::MatrixXd m(m_, encoders_);
    for (Eigen::Index c = 0; c < m.rows(); ++c)
      for (Eigen::Index i = 0; i < m.cols(); ++i) m(c, i) = job_.mean_sum(sum++);
    return m;
  }

  Eigen::MatrixXd covariance(std::size_t sum) const {
    Eigen::MatrixXd m(m_, m_);
    for (Eigen::Index r = 0; r < m.rows(); ++r)
      for (Eigen::Index c = 0; c <= r; ++c) m(r, c) = m(c, r) = job_.mean_sum(sum++);
    return m;
  }

  const WorkspaceJob& job_;
  const OperationalModel& model_;
  const std::vector<Norms>& filters_;
  const Configurations& configurations_;
  const WorkspaceOptions& options_;
  const FigureLayout& figures_;
  const SumLayout& sums_;
  std::size_t m_, encoders_;
};

}  // namespace

WorkspaceJob::WorkspaceJob(const OperationalModel& model, const std::vector<Norms>& filters,
                           const Configurations& configurations, const WorkspaceOptions& options)
    : joints_(model.chain.independent.size()),
      total_(size(configurations)),
      configurations_(configurations),
      options_(options),
      kernels_(select_kernels<BoundKernels>(options.instructions)),
      sampler_(configurations, options.instructions),
      errors_(model,
              {.rigorous = !options.brief,
               .shares = !options.brief,
               .filters = filters,
               .noise_in_motion = options.noise_in_motion},
              options.instructions),
      exact_(total_ <= exact_percentiles_limit),
      joined_(errors_.figures().count),
      sampled_largest_(joined_.size(), -1.0),
      sums_(errors_.sums().count) {
  if (exact_)
    values_ = AlignedNumbers(joined_.size() * total_);
  else
    take_sample();
}

void WorkspaceJob::run() {
  sweep();
  if (exact_ || percentiles_are_counted()) return;
  // The sample was not representative: count all bins.
  counted_.assign(joined_.size(), CountedBins{});
  sweep();
}

void WorkspaceJob::sweep() {
  joined_.assign(joined_.size(), JoinedTally{});
  sums_.assign(sums_.size(), 0);
  histograms_.clear();
  largest_ = sampled_largest_;
  const unsigned threads = thread_count(options_.threads);
  std::vector<Worker> workers;
  for (unsigned i = 0; i < std::min<std::uint64_t>(threads, blocks()); ++i) workers.push_back(worker());
  // The maxima of one wave of blocks are known to the next; the first waves are short. Texts of a wave are
  // held in memory.
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
    std::vector<Histogram>& histograms = worker.counts.histograms();
    if (histograms_.empty())
      histograms_ = std::move(histograms);
    else
      for (std::size_t f = 0; f < histograms.size(); ++f) histograms_[f].append(histograms[f]);
  }
}

bool WorkspaceJob::percentiles_are_counted() const {
  const std::vector<std::uint64_t> ranks = percentile_ranks(total_);
  return std::ranges::all_of(histograms_, [&](const Histogram& h) {
    return std::ranges::all_of(ranks, [&](std::uint64_t rank) { return h.counts(rank); });
  });
}

Statistic WorkspaceJob::statistic_of(std::size_t figure) const {
  const JoinedTally& tally = joined_[figure];
  if (exact_) return statistic(tally, order_statistics({values_.data() + figure * total_, total_}, tally));
  return statistic(tally, [&](std::uint64_t rank) {
    return histograms_[figure].order_statistic(rank, tally.min(), tally.max());
  });
}

WorkspaceJob::Worker WorkspaceJob::worker() const {
  return {sampler_, errors_, AlignedNumbers(joints_ * batch_size),
          AlignedNumbers(joined_.size() * batch_size), BlockCounts(empty_histograms())};
}

std::vector<Histogram> WorkspaceJob::empty_histograms() const {
  std::vector<Histogram> empty;
  for (std::size_t f = 0; f < lowest_bins_.size(); ++f)
    empty.emplace_back(lowest_bins_[f], counted_[f], usual_[f]);
  return empty;
}

/// Computes a block of configurations spread over the job, to set the same bins for all threads: their span,
/// the bins near the percentiles, and a lower bound of each maximum.
void WorkspaceJob::take_sample() {
  lowest_bins_.assign(joined_.size(), 0);
  counted_.resize(joined_.size());
  usual_.resize(joined_.size());
  Worker w = worker();
  std::vector<Tally> tallies(joined_.size()), unused(joined_.size());
  // Consecutive points of Sobol's sequence are not independent: take the distribution from random points.
  const bool correlated = configurations_.method == SamplingMethod::sobol;
  const Configurations at_random{.method = SamplingMethod::random, .ranges = configurations_.ranges};
  Sampler random(at_random, options_.instructions);
  for (std::uint64_t batch = 0; batch * batch_size < block_size; ++batch) {
    draw_sample(batch, w);
    w.errors(w.q.data(), w.figures.data());
    kernels_.tally(tallies.size(), w.figures.data(), 0, tallies.data(),
                   correlated ? nullptr : w.counts.lists());
    if (!correlated) continue;
    random(batch * batch_size, w.q.data());
    w.errors(w.q.data(), w.figures.data());
    kernels_.tally(unused.size(), w.figures.data(), 0, unused.data(), w.counts.lists());
  }
  for (std::size_t f = 0; f < joined_.size(); ++f) {
    const SampledBins sample(w.counts.list(f), w.counts.lists()[f].next);
    lowest_bins_[f] = Histogram::lowest_bin(sample[BlockCounts::block_size * 95 / 100]);
    if (std::isfinite(tallies[f].max)) sampled_largest_[f] = clearly_smaller * tallies[f].max;
    // Batches are seen once: a second sweep is not possible.
    if (!options_.text && !options_.visit) counted_[f] = sample.near_percentiles();
    usual_[f] = sample.usual();
  }
}

/// Batch `batch` of the sample. Neighbours in a grid or a list are correlated: each configuration is taken
/// from a different batch.
void WorkspaceJob::draw_sample(std::uint64_t batch, Worker& w) const {
  const auto random_first = [&](std::uint64_t i) {
    return random_bits(batch, i, 0) % (total_ / batch_size) * batch_size;
  };
  if (configurations_.method == SamplingMethod::sobol || configurations_.method == SamplingMethod::random) {
    w.sampler(random_first(0), w.q.data());
    return;
  }
  AlignedNumbers neighbours(w.q.size());
  for (std::size_t i = 0; i < batch_size; ++i) {
    w.sampler(random_first(i), neighbours.data());
    const std::size_t chosen = random_bits(batch, i, 1) % batch_size;
    for (std::size_t j = 0; j < joints_; ++j) w.q[j * batch_size + i] = neighbours[j * batch_size + chosen];
  }
}

void WorkspaceJob::block(Worker& w, std::uint64_t first, BlockResult& result) {
  result.count = std::min(block_size, total_ - first);
  result.tallies.assign(joined_.size(), Tally{});
  result.text.clear();
  // Only values above the maximum so far are searched for their configuration.
  for (std::size_t f = 0; f < joined_.size(); ++f) result.tallies[f].max = largest_[f];
  std::vector<double> surplus(errors_.sums().count);
  for (std::uint64_t done = 0; done < result.count; done += batch_size) {
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(batch_size, result.count - done));
    w.sampler(first + done, w.q.data());
    if (count < batch_size) surplus = pad(w, count);
    w.errors(w.q.data(), w.figures.data());
    keep(w, first + done, count, result.tallies);
    const ConfigurationBatch batch{first + done, count, w.q.data(), w.figures.data(), errors_.figures()};
    if (options_.text) result.text += options_.text(batch);
    if (options_.visit) options_.visit(batch);
  }
  w.counts.end_of_block(result.count / batch_size * batch_size);
  result.sums = w.errors.take_sums();
  for (std::size_t s = 0; s < result.sums.size(); ++s)
    if (s < errors_.sums().arms && std::isfinite(result.sums[s])) result.sums[s] -= surplus[s];
}

/// Pads an incomplete last batch with its first configuration.
/// @returns the contribution of the padding to the sums, from a batch of that configuration alone (infinite
/// sums are not corrected)
std::vector<double> WorkspaceJob::pad(Worker& w, std::size_t count) const {
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

void WorkspaceJob::keep(Worker& w, std::uint64_t first, std::size_t count, std::vector<Tally>& tallies) {
  const double* const figures = w.figures.data();
  if (count == batch_size) {
    kernels_.tally(tallies.size(), figures, first, tallies.data(), exact_ ? nullptr : w.counts.lists());
  } else {  // without the padding
    for (std::size_t f = 0; f < tallies.size(); ++f) {
      tally_some(figures + f * batch_size, count, first, tallies[f]);
      for (std::size_t i = 0; i < count && !exact_; ++i) w.counts.add(f, figures[f * batch_size + i]);
    }
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

const Statistic* statistic_of(const Workspace& w, const Figure& f) {
  const auto pointer = [](const std::optional<Statistic>& s) { return s ? &*s : nullptr; };
  if (f.filter < 0) {
    const CoordinateStatistics& position = w.coordinates[f.signal];
    return f.bound == Bound::worst_case            ? &position.worst_case
           : f.bound == Bound::worst_case_rigorous ? &position.worst_case_rigorous
                                                   : &position.sigma;
  }
  const DerivativeStatistics& behind = w.derivatives[f.filter][f.signal];
  return f.bound == Bound::worst_case           ? &behind.worst_case
         : f.bound == Bound::sigma              ? pointer(behind.sigma)
         : f.bound == Bound::sigma_quantization ? pointer(behind.sigma_quantization)
                                                : pointer(behind.sigma_in_motion);
}

Workspace workspace(const OperationalModel& model, const std::vector<Norms>& filters,
                    const Configurations& configurations, const WorkspaceOptions& options) {
  require_moderate_angles(model.chain, configurations);
  WorkspaceJob job(model, filters, configurations, options);
  job.run();
  return Summary(job, model, filters, configurations, options).workspace();
}

}  // namespace qerr
