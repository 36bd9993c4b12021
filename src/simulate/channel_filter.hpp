#pragma once

#include <vector>

#include "lanes/aligned.hpp"
#include "qerr/filter/filter.hpp"
#include "simulate/kernels.hpp"

namespace qerr {

/// One filter on many channels that stand side by side, batch after batch: a FilterBank in lanes, from which
/// it differs by rounding.
class ChannelFilter {
 public:
  /// @param width  of a row of channels, a multiple of the lanes
  ChannelFilter(const Filter&, std::size_t width, InstructionSet = instruction_set());

  /// As if this row had always been the input: no transient of a constant remains.
  void settle(const double* row);

  /// Filters rows that stand `stride` numbers apart, at most batch_size of them.
  /// @param out  rows side by side, aligned to 64 bytes
  void operator()(const double* in, std::size_t stride, std::size_t rows, double* out);

 private:
  void through_taps(const double* in, std::size_t stride, std::size_t rows, double* out);

  std::vector<SectionPlan> sections_;
  std::vector<double> taps_;
  std::size_t width_;
  const SimulationKernels& kernels_;
  AlignedNumbers state_;  // [section][2][width]
  AlignedNumbers past_;   // the inputs that the taps reach back to, then those of the batch
};

}  // namespace qerr
