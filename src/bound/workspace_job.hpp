#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "bound/batched_error.hpp"
#include "bound/histogram.hpp"
#include "bound/kernels.hpp"
#include "kinematics/sampler.hpp"
#include "lanes/batch.hpp"
#include "qerr/bound/workspace.hpp"

namespace qerr {

/// Histograms of all figures of one thread. Kernels list the bins of a block of configurations; at its end
/// they are counted figure by figure, so that each histogram is in the first-level cache while it is used.
class BlockCounts {
 public:
  /// Values per figure in one block.
  static constexpr std::size_t block_size = 64 * batch_size;

  /// @param empty  [figure]: its empty histogram
  explicit BlockCounts(std::vector<Histogram> empty);

  /// [figure]: lists of the block, for the kernel.
  BinList* lists() { return lists_.data(); }

  /// Begin of the list of figure f. The stride is not a power of two, which would map all lists to the same
  /// cache lines; a kernel writes up to a vector beyond the end.
  std::int32_t* list(std::size_t f) { return bins_.get() + f * (block_size + batch_size); }

  /// Adds a value of figure f that the kernel has not listed.
  void add(std::size_t f, double value) { histograms_[f].add(value); }

  /// Counts the listed bins and clears the lists.
  /// @param values  number of values per figure in the block
  void end_of_block(std::uint64_t values);

  std::vector<Histogram>& histograms() { return histograms_; }

 private:
  std::vector<Histogram> histograms_;
  std::unique_ptr<std::int32_t[]> bins_;
  std::vector<BinList> lists_;
};

/// Sorted bins (leading bits) of a sample of values, to plan the histogram of many more.
///
/// Counting only the bins near the percentiles saves 38 % of the CPU time of `analyze`: 25 instead of 40 ns
/// per configuration (Panda, x y z rx ry rz, 2e7 Sobol points, one AVX-512 thread of a shared machine;
/// measured by leaving CountedBins at its default).
class SampledBins {
 public:
  /// @pre begin < end
  SampledBins(const std::int32_t* begin, const std::int32_t* end);

  /// Bin of the order statistic of a rank. Values more than 64 octaves below the largest, and infinite ones,
  /// have the adjacent bin beyond the others.
  std::int32_t operator[](std::uint64_t rank) const;

  /// Bins that the percentiles of all values need: 4.5 standard deviations (of the sample's percentile) on
  /// either side of the lowest one, and everything from as far below the next one on. For independent values
  /// three edges in a million are on the wrong side.
  CountedBins near_percentiles() const;

  /// Bins from the smallest value to an octave above the largest.
  Histogram::Usual usual() const;

 private:
  std::uint64_t count_;
  std::int32_t first_;
  std::vector<std::uint32_t> counts_;
};

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
