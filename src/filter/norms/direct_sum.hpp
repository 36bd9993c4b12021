#pragma once

#include <cstdint>
#include <vector>

#include "filter/run/cascade.hpp"
#include "qerr/filter/filter.hpp"

namespace qerr {

/// sum |h_k| over k < count, and a proven bound of its rounding error.
struct PartialSum {
  double sum = 0;
  double error = 0;
};

/// Sums |h_k| sample by sample in double-double, with a running bound of the rounding errors.
class DirectSum {
 public:
  /// @pre no taps, at least one section
  /// @param lift  (1 + lift) times the largest pole modulus is below 1
  DirectSum(const Filter&, double lift);

  PartialSum sum(std::int64_t count) const;
  /// Upper bound of sum |h_k| over k >= from (Cauchy and Schwarz).
  double tail(std::int64_t from) const;

 private:
  /// ||.||_1 from a disturbance of a section to the filter's output.
  struct Sensitivity {
    double input = 0, first_state = 0, second_state = 0, output = 0;
  };
  FilterPlan<DoubleDouble> plan_;
  std::vector<Sensitivity> sensitivity_;
  double lift_ = 0;
  double lifted_ = 0;  // ||H||_2, lifted
};

}  // namespace qerr
