#pragma once

#include <cstdint>

#include "qerr/filter/filter.hpp"

namespace qerr {

/// sum |h_k| over k < count, and a proven bound of its rounding.
struct PartialSum {
  double sum = 0;
  double error = 0;
};

/// What one rounding in the recursion of a filter can do to sum |h_k|, found once.
class DirectSum {
 public:
  /// @pre no taps
  /// @param lift  (1 + lift) times the largest pole modulus is below 1
  DirectSum(const Filter&, double lift);

  /// In double-double.
  PartialSum sum(std::int64_t count) const;
  /// Upper bound of sum |h_k| over k >= from (Cauchy and Schwarz).
  double tail(std::int64_t from) const;

 private:
  struct Stage {
    bool second = false;
    DoubleDouble b0, b1, b2, a0, a01, inverse;
    // ||.||_1 from the stage's input, its two states and its output to the filter's output.
    double from_input = 0, from_first = 0, from_second = 0, from_output = 0;
  };
  std::vector<Stage> stages_;
  DoubleDouble gain_;
  double lift_ = 0;
  double lifted_ = 0;  // ||H||_2, lifted
};

}  // namespace qerr
