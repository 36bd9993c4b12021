#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "bound/histogram.hpp"
#include "bound/kernels.hpp"
#include "lanes/batch.hpp"

namespace qerr {

/// Histograms of all figures of one thread. The bins of a block are listed first and counted at its end,
/// figure after figure: so a figure's histogram is in the nearest memory when it is needed.
class BlockCounts {
 public:
  /// Values of a figure in one block.
  static constexpr std::size_t block_size = 64 * batch_size;

  /// @param empty  of every figure
  explicit BlockCounts(std::vector<Histogram> empty);

  /// For the kernel: those of the block, of every figure.
  BinList* lists() { return lists_.data(); }

  /// Where the list of figure f begins. Not a power of two apart, or all would want the same lines of the
  /// cache; and a kernel writes beyond the end.
  std::int32_t* list(std::size_t f) { return bins_.get() + f * (block_size + batch_size); }

  /// A value of figure f that the kernel has not listed.
  void add(std::size_t f, double value) { histograms_[f].add(value); }

  /// Counts what is listed.
  /// @param values  of every figure that the kernel has seen
  void end_of_block(std::uint64_t values);

  std::vector<Histogram>& histograms() { return histograms_; }

 private:
  std::vector<Histogram> histograms_;
  std::unique_ptr<std::int32_t[]> bins_;
  std::vector<BinList> lists_;
};

}  // namespace qerr
