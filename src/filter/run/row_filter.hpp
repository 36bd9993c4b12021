#pragma once

#include "filter/run/cascade.hpp"
#include "filter/run/filter_kernels.hpp"
#include "lanes/batch.hpp"
#include "qerr/core/instruction_set.hpp"

namespace qerr {

/// One filter on many channels, several rows of samples per call. Differs from a Cascade<double> per channel
/// by rounding.
class RowFilter {
 public:
  /// @param width  channels per row, a multiple of 8
  /// @param most_rows  per call
  RowFilter(const Filter&, std::size_t width, std::size_t most_rows, InstructionSet = instruction_set());

  /// To zero states, as constructed.
  void reset();

  /// To the steady state for a constant input equal to this row: no transient of it remains.
  void settle(const double* row);

  /// Filters rows that are `stride` numbers apart.
  /// @param out  rows `width` apart, aligned to 64 bytes; not `in`
  void operator()(const double* in, std::size_t stride, std::size_t rows, double* out);

 private:
  void run_taps(const double* in, std::size_t stride, std::size_t rows, double* out);

  FilterPlan<double> plan_;
  std::size_t width_;
  const FilterKernels* kernels_;
  AlignedNumbers state_;  // [section][s1, s2][width]
  AlignedNumbers past_;   // the previous inputs of the taps, then those of this call
};

}  // namespace qerr
