#pragma once

#include <vector>

#include "filter/run/row_filter.hpp"
#include "simulate/run.hpp"

namespace qerr {

/// Keeps the errors of a run in its first samples behind the settling.
class ErrorTracer {
 public:
  /// @param width  of a row of channels, of which the first ones are the exact errors of the coordinates
  ErrorTracer(const Job&, Eigen::Index coordinates, std::size_t width);

  /// @param rows  channels of samples first .. first + count - 1, at most batch_size
  /// @pre called for all samples, in order
  void add(const double* rows, std::uint64_t first, std::size_t count);

  std::vector<ErrorTrace> traces() && { return std::move(traces_); }
  const std::vector<ErrorTrace>& traces() const& { return traces_; }

 private:
  struct Filtered {
    RowFilter filter;
    std::uint64_t every;
  };
  void keep(std::size_t output, const double* row);

  std::size_t width_;
  std::uint64_t settling_,
      end_;  // samples of the motion: the first one that is kept, and the one after the last
  std::vector<Filtered> filters_;
  AlignedNumbers filtered_;
  std::vector<ErrorTrace> traces_;
};

}  // namespace qerr
