#pragma once

#include <optional>

#include "filter/run/row_filter.hpp"
#include "simulate/run_statistics.hpp"

namespace qerr {

/// Statistics of a filter's output on many channels; those of a RowFilter up to rounding.
///
/// Most filters are up to two differences and one or two sections that settle within some hundred samples.
/// For these, one pass computes all sections and the sums, without storing rows, and with fewer operations
/// than the integrators of section_recursion.hpp need: with the states s = s1/2 and r = (s1 + s2)/4 of a
/// section, the second state is updated by one addition, and the output is a sum of states (FusedSection).
/// Slow sections would lose digits: the factor of s is 1 minus a number proportional to the cut-off. They go
/// through a RowFilter.
///
/// Gain: `qerr simulate` of configs/kuka_lwr with its two filters, sines in all joints at 1 kHz and one
/// thread takes 1.14 s of CPU time for 20000 s of motion instead of 1.50 s with RowFilter alone (-24 %), and
/// 0.81 s instead of 1.03 s for 64 runs of 200 s (-21 %), with AVX-512.
class FusedFilter {
 public:
  /// @param width  of a row of channels, a multiple of the lanes
  FusedFilter(const Filter&, std::size_t width, InstructionSet = instruction_set());

  /// To the steady state for a constant input equal to this row: no transient of it remains.
  void settle(const double* row);

  /// Filters rows that are `stride` numbers apart, at most batch_size of them; the output is dropped.
  void pass(const double* in, std::size_t stride, std::size_t rows);

  /// Filters rows as `pass` does, and adds the output to the statistics of a block.
  void tally(const double* in, std::size_t stride, std::size_t rows, std::uint64_t block, RunStatistics&);

 private:
  /// Rows per call of the RowFilter: they stay in the first-level cache from section to section.
  static constexpr std::size_t rows_at_once = 16;

  bool fuse(const Filter&);
  void run_rows(const double* in, std::size_t stride, std::size_t rows, std::uint64_t block, RunStatistics*);
  void run_fused(const double* in, std::size_t stride, std::size_t rows, std::size_t peaks,
                 const RunStatistics::Place&);

  std::size_t width_;
  const SimulationKernels& kernels_;
  std::optional<RowFilter> rows_;  // for filters that are not fusible; then the plan is not used
  FusedPlan plan_{};
  double gain_ = 1;
  AlignedNumbers state_;   // [section][s, r][width], [difference][width]
  AlignedNumbers buffer_;  // sums that are dropped, or rows of the RowFilter's output
  ChannelTally dropped_{};
};

}  // namespace qerr
