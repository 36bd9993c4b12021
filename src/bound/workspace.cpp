#include "qerr/bound/workspace.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "kernels.hpp"
#include "qerr/bound/histogram.hpp"
#include "qerr/core/aligned.hpp"
#include "qerr/core/error.hpp"
#include "qerr/core/lanes.hpp"
#include "qerr/core/parallel.hpp"
#include "qerr/core/quantity.hpp"
#include "qerr/core/random.hpp"
#include "qerr/kinematics/sampler.hpp"

namespace qerr {

namespace {

constexpr std::uint64_t block_size = 64 * batch_size;

ErrorFigures asked_for(const std::vector<Norms>& filters, const WorkspaceOptions& options) {
  return {!options.brief, !options.brief, false, filters, options.noise_in_motion};
}

/// What one block of configurations gives.
struct BlockResult {
  std::uint64_t count = 0;
  std::vector<Tally> tallies;
  std::vector<double> sums;
  std::string text;
};

/// All that a thread writes to while it works.
struct Worker {
  Sampler sampler;
  BatchedError errors;
  AlignedNumbers q, figures;
  std::vector<std::uint16_t> bins;    // [figure][block_size]
  std::vector<Histogram> histograms;  // [figure]
};

/// The job: blocks of configurations, taken by whichever thread is free, joined in their order.
class Job {
 public:
  Job(const OperationalModel& model, const std::vector<Norms>& filters, const Configurations& configurations,
      const WorkspaceOptions& options)
      : joints_(model.chain.independent.size()),
        total_(size(configurations)),
        options_(options),
        kernels_(bound_kernels(options.instructions)),
        sampler_(configurations, options.instructions),
        errors_(model, asked_for(filters, options), options.instructions),
        exact_(total_ <= exact_percentiles_limit),
        joined_(errors_.figures().count),
        largest_(joined_.size(), -1.0),
        sums_(errors_.sums().count) {
    if (exact_)
      values_ = AlignedNumbers(joined_.size() * total_);
    else
      set_lowest_bins();
  }

  void run() {
    const unsigned threads = thread_count(options_.threads);
    std::vector<Worker> workers;
    for (unsigned i = 0; i < std::min<std::uint64_t>(threads, blocks()); ++i) workers.push_back(worker());
    // Texts wait in memory for their turn.
    const std::uint64_t blocks_per_wave = options_.text ? 16 : 256;
    for (std::uint64_t wave = 0; wave < blocks(); wave += blocks_per_wave) {
      std::vector<BlockResult> results(std::min(blocks_per_wave, blocks() - wave));
      std::atomic<std::size_t> next{0};
      parallel_for(workers.size(), threads, [&](std::size_t i) {
        for (std::size_t b = next++; b < results.size(); b = next++)
          results[b] = block(workers[i], (wave + b) * block_size);
      });
      for (const BlockResult& result : results) join(result);
      for (std::size_t f = 0; f < joined_.size(); ++f) largest_[f] = joined_[f].max();
      if (options_.progress)
        options_.progress(std::min(total_, (wave + results.size()) * block_size), total_);
    }
    for (std::size_t i = 1; i < workers.size() && !exact_; ++i)
      for (std::size_t f = 0; f < joined_.size(); ++f)
        workers[0].histograms[f].append(workers[i].histograms[f]);
    if (!exact_ && !workers.empty()) histograms_ = std::move(workers[0].histograms);
  }

  const BatchedError& errors() const { return errors_; }
  std::uint64_t total() const { return total_; }
  bool exact() const { return exact_; }

  /// Sum number s, averaged over the configurations; maxima as they are.
  double mean_sum(std::size_t s) const {
    return static_cast<double>(sums_[s] / static_cast<long double>(total_));
  }
  double maximum(std::size_t s) const { return static_cast<double>(sums_[s]); }
  std::uint64_t at_max(std::size_t figure) const { return joined_[figure].at_max(); }

  Statistic statistic_of(std::size_t figure) const {
    const JoinedTally& tally = joined_[figure];
    if (exact_) return statistic(tally, order_statistics(values_.data() + figure * total_, total_));
    return statistic(tally, [&](std::uint64_t rank) {
      return histograms_[figure].order_statistic(rank, tally.min(), tally.max());
    });
  }

 private:
  std::uint64_t blocks() const { return (total_ + block_size - 1) / block_size; }

  Worker worker() const {
    Worker w{
        sampler_, errors_, AlignedNumbers(joints_ * batch_size), AlignedNumbers(joined_.size() * batch_size),
        {},       {}};
    if (exact_) return w;
    w.bins.resize(joined_.size() * block_size);
    for (const std::int64_t lowest : lowest_bins_) w.histograms.emplace_back(lowest);
    return w;
  }

  /// By the figures of some batches from all over the job, before it starts: every thread bins alike.
  void set_lowest_bins() {
    constexpr std::uint64_t looks = 64;
    Worker w = worker();
    std::vector<double> typical(joined_.size());
    for (std::uint64_t look = 0; look < looks; ++look) {
      w.sampler(random_bits(look, 0, 0) % (total_ / batch_size) * batch_size, w.q.data());
      w.errors(w.q.data(), w.figures.data());
      for (std::size_t f = 0; f < joined_.size(); ++f)
        for (std::size_t i = 0; i < batch_size; ++i)
          if (const double value = w.figures[f * batch_size + i]; std::isfinite(value))
            typical[f] = std::max(typical[f], value);
    }
    for (const double value : typical) lowest_bins_.push_back(Histogram::lowest_bin(value));
  }

  BlockResult block(Worker& w, std::uint64_t first) {
    BlockResult result{std::min(block_size, total_ - first), std::vector<Tally>(joined_.size()), {}, {}};
    // What is not larger than what was found before is no news.
    for (std::size_t f = 0; f < joined_.size(); ++f) result.tallies[f].max = largest_[f];
    std::vector<double> surplus(errors_.sums().count);
    for (std::uint64_t done = 0; done < result.count; done += batch_size) {
      const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(batch_size, result.count - done));
      w.sampler(first + done, w.q.data());
      if (count < batch_size) surplus = fill_up(w, count);
      w.errors(w.q.data(), w.figures.data());
      keep(w, first + done, count, done, result.tallies);
      if (options_.text)
        result.text += options_.text({first + done, count, w.q.data(), w.figures.data(), errors_.figures()});
    }
    for (std::size_t f = 0; f < w.histograms.size(); ++f)
      w.histograms[f].add(w.bins.data() + f * block_size, result.count);
    result.sums = w.errors.take_sums();
    for (std::size_t s = 0; s < result.sums.size(); ++s)
      if (s < errors_.sums().arms && std::isfinite(result.sums[s])) result.sums[s] -= surplus[s];
    return result;
  }

  /// The last batch may be a part of one: the rest is filled with its first configuration, whose surplus in
  /// the sums is found by a batch of nothing else.
  std::vector<double> fill_up(Worker& w, std::size_t count) const {
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

  /// @param place  of the batch in its block
  void keep(Worker& w, std::uint64_t first, std::size_t count, std::uint64_t place,
            std::vector<Tally>& tallies) {
    const double* const figures = w.figures.data();
    if (!exact_)
      kernels_.bins(figures, tallies.size(), lowest_bins_.data(), w.bins.data() + place, block_size);
    if (count == batch_size) {
      kernels_.tally(figures, tallies.size(), first, tallies.data());
    } else {
      for (std::size_t f = 0; f < tallies.size(); ++f)
        tally_some(figures + f * batch_size, count, first, tallies[f]);
    }
    if (!exact_) return;
    for (std::size_t f = 0; f < tallies.size(); ++f)
      std::copy_n(figures + f * batch_size, count, &values_[f * total_ + first]);
  }

  void join(const BlockResult& block) {
    for (std::size_t f = 0; f < joined_.size(); ++f) joined_[f].append(block.tallies[f], block.count);
    for (std::size_t s = 0; s < sums_.size(); ++s)
      sums_[s] =
          s < errors_.sums().arms ? sums_[s] + block.sums[s] : std::max<long double>(sums_[s], block.sums[s]);
    if (options_.write) options_.write(block.text);
  }

  std::size_t joints_;
  std::uint64_t total_;
  const WorkspaceOptions& options_;
  const BoundKernels& kernels_;
  Sampler sampler_;
  BatchedError errors_;
  bool exact_;
  AlignedNumbers values_;                  // [figure][configuration], where percentiles are exact
  std::vector<std::int64_t> lowest_bins_;  // [figure]
  std::vector<JoinedTally> joined_;        // [figure]
  std::vector<double> largest_;            // [figure], of the waves before
  std::vector<long double> sums_;
  std::vector<Histogram> histograms_;  // [figure]
};

/// Largest |coordinate| of an independent joint over the configurations [rad or m].
double largest_coordinate(const Configurations& c, std::size_t joint) {
  if (c.method != SamplingMethod::list)
    return std::max(std::abs(c.ranges[joint].lower), std::abs(c.ranges[joint].upper));
  double largest = 0;
  for (const Eigen::VectorXd& point : c.points)
    largest = std::max(largest, std::abs(point[static_cast<Eigen::Index>(joint)]));
  return largest;
}

/// Beyond, sines lose the digits that are promised.
void require_moderate_angles(const Chain& chain, const Configurations& c) {
  for (const ChainJoint& joint : chain.joints) {
    if (joint.prismatic) continue;
    const double angle =
        std::abs(joint.multiplier) * largest_coordinate(c, joint.coordinate) + std::abs(joint.offset);
    if (!(angle <= lanes::largest_angle))
      throw Error({{},
                   "configurations",
                   "joint '" + joint.name + "' must stay within 2^20 rad, some 167 000 turns",
                   shortest(angle) + " rad",
                   "angles that differ by whole turns are the same: take smaller ones"});
  }
}

/// Makes a Workspace of what the job has found.
class Summary {
 public:
  Summary(const Job& job, const OperationalModel& model, const std::vector<Norms>& filters,
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
    for (std::size_t c = 0; c < m_; ++c) w.coordinates.push_back(coordinate(c));
    for (std::size_t f = 0; f < filters_.size(); ++f) w.derivatives.push_back(derivatives(f, w));
    w.mean_covariance = covariance(sums_.covariance);
    if (!options_.brief) add_details(w);
    if (sums_.pitch < sums_.count) w.smallest_cosine_of_pitch = 1 - job_.maximum(sums_.pitch);
    return w;
  }

 private:
  Statistic of(std::size_t figure) const {
    Statistic s = job_.statistic_of(figure);
    if (job_.total() > 0) s.at_max = draw(configurations_, job_.at_max(figure), 1).col(0);
    return s;
  }

  CoordinateStatistics coordinate(std::size_t c) const {
    CoordinateStatistics s{of(figures_.worst_case + c), {}, of(figures_.sigma + c), {}, {}};
    if (options_.brief) return s;
    s.worst_case_rigorous = of(figures_.rigorous + c);
    s.share = above(1e-24, matrix(sums_.share).row(static_cast<Eigen::Index>(c)));
    s.share_worst_case = above(1e-12, matrix(sums_.worst_share).row(static_cast<Eigen::Index>(c)));
    return s;
  }

  /// A zero comes out of trigonometry as 1e-17, and shares of such noise would look like figures.
  static Eigen::VectorXd above(double rounding, const Eigen::VectorXd& shares) {
    return (shares.array() > rounding).select(shares, 0.0);
  }

  std::vector<DerivativeStatistics> derivatives(std::size_t f, const Workspace& w) const {
    std::vector<DerivativeStatistics> all;
    for (std::size_t c = 0; c < m_; ++c) {
      const std::size_t at = f * m_ + c;
      all.push_back({job_.errors().own_worst_case()
                         ? of(figures_.filtered_worst + at)
                         : scaled(w.coordinates[c].worst_case, filters_[f].l1.upper),
                     job_.errors().own_sigma() ? of(figures_.filtered_sigma + at)
                                               : scaled(w.coordinates[c].sigma, filters_[f].h2),
                     {}});
      if (is_known(options_.noise_in_motion, f)) all.back().sigma_in_motion = of(figures_.in_motion + at);
    }
    return all;
  }

  void add_details(Workspace& w) const {
    w.mean_variance_parts = matrix(sums_.variance_parts);
    w.largest_arms.resize(static_cast<Eigen::Index>(encoders_));
    for (std::size_t i = 0; i < encoders_; ++i)
      w.largest_arms[static_cast<Eigen::Index>(i)] = job_.maximum(sums_.arms + i);
    if (job_.total() == 0) return;
    w.largest_at = draw(configurations_, job_.at_max(figures_.trace), 1).col(0);
    const OperationalError largest = operational_error(model_, w.largest_at);
    w.covariance_at_largest = qerr::covariance(largest);
    for (std::size_t f = 0; f < filters_.size() && job_.errors().own_sigma(); ++f)
      w.filtered.push_back(
          {covariance(sums_.filtered + f * m_ * (m_ + 1) / 2),
           qerr::covariance(largest, filters_[f].h2, gains_behind(model_.sources, f, filters_[f].h2))});
  }

  /// Coordinates x encoders.
  Eigen::MatrixXd matrix(std::size_t sum) const {
    Eigen::MatrixXd m(static_cast<Eigen::Index>(m_), static_cast<Eigen::Index>(encoders_));
    for (Eigen::Index c = 0; c < m.rows(); ++c)
      for (Eigen::Index i = 0; i < m.cols(); ++i) m(c, i) = job_.mean_sum(sum++);
    return m;
  }

  Eigen::MatrixXd covariance(std::size_t sum) const {
    Eigen::MatrixXd m(static_cast<Eigen::Index>(m_), static_cast<Eigen::Index>(m_));
    for (Eigen::Index r = 0; r < m.rows(); ++r)
      for (Eigen::Index c = 0; c <= r; ++c) m(r, c) = m(c, r) = job_.mean_sum(sum++);
    return m;
  }

  const Job& job_;
  const OperationalModel& model_;
  const std::vector<Norms>& filters_;
  const Configurations& configurations_;
  const WorkspaceOptions& options_;
  const FigureLayout& figures_;
  const SumLayout& sums_;
  std::size_t m_, encoders_;
};

}  // namespace

Statistic scaled(const Statistic& s, double factor) {
  return {s.min * factor, s.mean * factor, s.max * factor, s.p50 * factor,
          s.p95 * factor, s.p99 * factor,  s.at_max};
}

Workspace workspace(const OperationalModel& model, const std::vector<Norms>& filters,
                    const Configurations& configurations, const WorkspaceOptions& options) {
  require_moderate_angles(model.chain, configurations);
  Job job(model, filters, configurations, options);
  job.run();
  return Summary(job, model, filters, configurations, options).workspace();
}

}  // namespace qerr
