#pragma once

#include <cstdint>
#include <vector>

#include "filter/run/cascade.hpp"
#include "qerr/filter/filter.hpp"

namespace qerr {

/// Relative allowance for a norm of a designed filter against the norm of the ideal one: a design computes
/// its coefficients with a few roundings to double. 0 for filters that are not designed by a family.
inline double design_rounding(const Filter& filter) {
  constexpr double of_section = 1e-15;
  return filter.designed ? of_section * static_cast<double>(1 + filter.sections.size()) : 0;
}

/// An upper bound of sqrt(sum (1 + lift)^(2k) h_k^2), the H2 norm of H(z/(1 + lift)), within 10 % of it;
/// infinite unless every pole is proven to be inside |z| < 1/(1 + lift).
/// @pre no taps
double lifted_norm(const Filter&, double lift);

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
