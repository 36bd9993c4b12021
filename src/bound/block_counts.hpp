#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "bound/histogram.hpp"
#include "bound/kernels.hpp"
#include "lanes/batch.hpp"

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

}  // namespace qerr
