#pragma once

#include <optional>

#include "filter/run/row_filter.hpp"
#include "simulate/run_statistics.hpp"

namespace qerr {

/// A filter on many channels of which statistics alone are wanted: what a ChannelFilter gives, from which it
/// differs by rounding.
///
/// Most filters are a difference or two, and one or two sections that settle within some hundred samples.
/// Those take rows through all of that and into the sums in one pass, and with fewer operations than
/// integrators: with s = s1/2 and r = (s1 + s2)/4 of a section in integrators, one addition takes the second
/// state on, and the output is a sum of states. Slower sections would lose digits by that: the factor of s
/// is 1 less what makes it settle.
class TalliedFilter {
 public:
  /// @param width  of a row of channels, a multiple of the lanes
  TalliedFilter(const Filter&, std::size_t width, InstructionSet = instruction_set());

  /// As if this row had always been the input: no transient of a constant remains.
  void settle(const double* row);

  /// Filters rows that stand `stride` numbers apart, at most batch_size of them; nobody looks at the output.
  void pass(const double* in, std::size_t stride, std::size_t rows);

  /// Filters them, and adds the output to a block.
  void tally(const double* in, std::size_t stride, std::size_t rows, std::uint64_t block, RunStatistics&);

 private:
  /// As many rows as stay in the first-level cache while they pass the sections of a ChannelFilter.
  static constexpr std::size_t rows_at_once = 16;

  bool tighten(const Filter&);
  void slowly(const double* in, std::size_t stride, std::size_t rows, std::uint64_t block, RunStatistics*);
  void through_sections(const double* in, std::size_t stride, std::size_t rows, std::size_t peaks,
                        const RunStatistics::Place&);

  std::size_t width_;
  const SimulationKernels& kernels_;
  std::optional<RowFilter> slow_;  // of any filter; then nothing else is
  TightFilter plan_{};
  double gain_ = 1;
  AlignedNumbers state_;    // [section][s, r][width], [difference][width]
  AlignedNumbers numbers_;  // where sums go that nobody looks at, or rows that come out
  ChannelTally nowhere_{};
};

}  // namespace qerr
