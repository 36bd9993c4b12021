#pragma once

#include <cstdint>
#include <vector>

#include "kernels.hpp"
#include "qerr/bound/histogram.hpp"
#include "qerr/core/batch.hpp"

namespace qerr {

/// Histograms of all figures of one thread, whose bins are counted a block later: by the kernel, while it
/// tallies the next block.
class DeferredCounts {
 public:
  static constexpr std::size_t block_size = batches_per_block * batch_size;

  /// @param lowest_bins  of every figure's histogram; none: nothing is counted
  /// @pre they outlive this
  explicit DeferredCounts(const std::vector<std::int64_t>& lowest_bins);

  /// Where the bins of a batch of this block go, and what is to be counted meanwhile of those of the block
  /// before: as bins of one figure follow each other, its histogram stays in the nearest memory.
  void plan(std::size_t batch, TallyPlan&);

  /// The block has `count` values of every figure. What still waits is counted.
  void end_of_block(std::size_t count);

  /// All histograms, once all is counted.
  std::vector<Histogram> finish();

 private:
  void count_waiting();

  const std::vector<std::int64_t>& lowest_;
  std::vector<Histogram> histograms_;
  std::vector<std::uint16_t> filling_, waiting_;  // [figure][block_size]
  std::vector<std::uint32_t*> counts_;            // of every figure
  std::size_t counted_ = 0, chunks_ = 0;          // of the waiting ones: 64 bins each, figure after figure
};

}  // namespace qerr
