#pragma once

#include <cstddef>
#include <vector>

#include "filter/run/filter_plan.hpp"

namespace qerr {

/// Runs a filter sample by sample, from zero states.
/// @tparam Number  double, or DoubleDouble for results that are proven or exact to the last digit of a double
template <class Number>
class Cascade {
 public:
  explicit Cascade(const Filter& filter);
  Number step(Number input);

 private:
  FilterPlan<Number> plan_;
  std::vector<SectionState<Number>> states_;
  std::vector<Number> past_;  // ring buffer of the inputs of the taps
  std::size_t newest_ = 0;
};

extern template class Cascade<double>;
extern template class Cascade<DoubleDouble>;

}  // namespace qerr
