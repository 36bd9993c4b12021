#pragma once

#include <vector>

#include "diagnose/surrogates/residual_kernels.hpp"
#include "lanes/aligned.hpp"
#include "qerr/filter/filter.hpp"

namespace qerr {

/// One filter on lanes that stand side by side: a FilterBank of some rows at a time, from which it differs by
/// rounding.
class ResidualFilter {
 public:
  /// @param most_rows  at a time
  ResidualFilter(const Filter&, std::size_t width, std::size_t most_rows, const ResidualKernels&);

  /// Forgets what it was given.
  void start();

  /// Filters the next rows. @param out  aligned to 64 bytes, as `in` is; not `in` itself
  void operator()(const double* in, std::size_t rows, double* out);

 private:
  const ResidualKernels* kernels_;
  std::size_t width_;
  std::vector<ResidualSection> sections_;
  std::vector<double> taps_;
  AlignedNumbers state_;  // [section][2][width]
  AlignedNumbers past_;   // the inputs that the taps reach back to, then those of these rows
};

}  // namespace qerr
