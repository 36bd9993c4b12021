#pragma once

#include <string>
#include <vector>

#include "bound/batched_error.hpp"
#include "bound/block_counts.hpp"
#include "bound/configuration_batch.hpp"
#include "bound/joined_tally.hpp"
#include "kinematics/sampler.hpp"
#include "lanes/aligned.hpp"
#include "qerr/bound/workspace.hpp"

namespace qerr {

/// Implementation of `workspace`: threads process blocks of configurations, which are joined in their order.
/// Borrows the configurations and the options.
class WorkspaceJob {
 public:
  WorkspaceJob(const OperationalModel&, const std::vector<Norms>& filters, const Configurations&,
               const WorkspaceOptions&);
  WorkspaceJob(const WorkspaceJob&) = delete;
  WorkspaceJob& operator=(const WorkspaceJob&) = delete;

  void run();

  const BatchedError& errors() const { return errors_; }
  std::uint64_t total() const { return total_; }
  bool exact() const { return exact_; }

  /// Sum s (SumLayout) divided by the number of configurations.
  double mean_sum(std::size_t s) const {
    return static_cast<double>(sums_[s] / static_cast<long double>(total_));
  }
  /// Maximum s (SumLayout).
  double maximum(std::size_t s) const { return static_cast<double>(sums_[s]); }
  std::uint64_t at_max(std::size_t figure) const { return joined_[figure].at_max(); }

  /// Statistic without `at_max`.
  Statistic statistic_of(std::size_t figure) const;

 private:
  static constexpr std::uint64_t block_size = BlockCounts::block_size;

  /// Results of one block of configurations.
  struct BlockResult {
    std::uint64_t count = 0;
    std::vector<Tally> tallies;
    std::vector<double> sums;
    std::string text;
  };

  /// State of one thread.
  struct Worker {
    Sampler sampler;
    BatchedError errors;
    AlignedNumbers q, figures;
    BlockCounts counts;
  };

  std::uint64_t blocks() const { return (total_ + block_size - 1) / block_size; }
  Worker worker() const;
  std::vector<Histogram> empty_histograms() const;
  void take_sample();
  void draw_sample(std::uint64_t batch, Worker&) const;
  void sweep();
  bool percentiles_are_counted() const;
  /// @param result  of an earlier block, whose memory is reused
  void block(Worker&, std::uint64_t first, BlockResult& result);
  std::vector<double> pad(Worker&, std::size_t count) const;
  void keep(Worker&, std::uint64_t first, std::size_t count, std::vector<Tally>&);
  void join(const BlockResult&);

  std::size_t joints_;
  std::uint64_t total_;
  const Configurations& configurations_;
  const WorkspaceOptions& options_;
  const BoundKernels& kernels_;
  Sampler sampler_;
  BatchedError errors_;
  bool exact_;
  AlignedNumbers values_;                  // [figure][configuration], if percentiles are exact
  std::vector<std::int32_t> lowest_bins_;  // [figure]
  std::vector<CountedBins> counted_;       // [figure]
  std::vector<Histogram::Usual> usual_;    // [figure]
  std::vector<JoinedTally> joined_;        // [figure]
  // [figure]: lower bounds of the maximum, from the sample and from the blocks so far
  std::vector<double> sampled_largest_, largest_;
  std::vector<long double> sums_;
  std::vector<Histogram> histograms_;  // [figure]
};

}  // namespace qerr
