#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "filter/run/section_recursion.hpp"
#include "lanes/batch.hpp"
#include "qerr/core/instruction_set.hpp"
#include "qerr/filter/filter.hpp"

namespace qerr {

/// A filter as it runs: sections, or the taps of a filter without sections.
///
/// A section whose output is a single multiple of low, band or high is divided by that factor; the gain and
/// all such factors are in the last section, or in the taps.
template <class Number>
struct FilterPlan {
  std::vector<NormalizedSection<Number>> sections;
  std::vector<Number> taps;
};

/// Divides a section by the only one of b0, b1, b2 that is not 0, if there is one. @returns it, or 1
template <class Number>
Number take_factor(NormalizedSection<Number>& s) {
  const Number zero(0), one(1);
  if (s.b1 == zero && s.b2 == zero) return std::exchange(s.b0, one);
  if (s.b0 == zero && s.b2 == zero) return std::exchange(s.b1, one);
  if (s.b0 == zero && s.b1 == zero) return std::exchange(s.b2, one);
  return one;
}

/// @tparam Number  double or DoubleDouble
template <class Number>
FilterPlan<Number> filter_plan(const Filter& filter) {
  const auto number = [](const DoubleDouble& c) { return static_cast<Number>(c); };
  FilterPlan<Number> plan;
  Number gain = number(filter.gain);
  for (const Section& s : filter.sections) {
    const Number a0 = number(s.a[0]), a01 = a0 + number(s.a[1]), a2 = number(s.a[2]);
    const Number inverse = Number(1) / (a01 + a2);
    plan.sections.push_back(
        {!(a2 == Number(0)), a0 * inverse, a01 * inverse, number(s.b[0]), number(s.b[1]), number(s.b[2])});
    gain *= inverse * take_factor(plan.sections.back());
  }
  for (const DoubleDouble& tap : filter.taps) plan.taps.push_back(number(tap));
  if (!plan.sections.empty()) {
    NormalizedSection<Number>& last = plan.sections.back();
    for (Number* b : {&last.b0, &last.b1, &last.b2}) *b *= gain;
  } else {
    if (plan.taps.empty()) plan.taps = {Number(1)};
    for (Number& tap : plan.taps) tap *= gain;
  }
  return plan;
}

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
