#pragma once

#include <optional>
#include <vector>

#include "filter/norms/multiprecision.hpp"
#include "filter/run/cascade.hpp"
#include "qerr/filter/filter.hpp"

namespace qerr {

/// Proven bounds of ||b/a - H|| for the filter H that was computed from the coefficients b, a (ascending in
/// z^-1, taken as exact); empty unless both are proven stable.
/// @param modulus  largest pole modulus, approximately
std::optional<Deviation> deviation_of(const Filter& h, const std::vector<double>& b,
                                      const std::vector<double>& a, double modulus);
std::optional<Deviation> deviation_of(const Filter& h, const std::vector<Binary1024>& b,
                                      const std::vector<Binary1024>& a, double modulus);

/// The plan of a filter for single precision or fixed point: each section but the last has gain 1 at 0 Hz, or
/// where it differentiates that of w/k0, so that no signal leaves the range of float.
FilterPlan<DoubleDouble> levelled_plan(const Filter&);

/// Bounds of a filter that runs in floating point by a plan and section_recursion.hpp, from a constant
/// input on, for inputs of magnitude at most one. Both scale with the input.
struct RecursionError {
  /// Largest |computed - exact| output [1/s^derivative]; infinite where the rounding might grow without end.
  double output = 0;
  double largest_signal = 0;  ///< of the inputs, states and sums of the sections: for a fixed point
};

/// The bound of the rounding, of input and coefficients, too; underflow aside.
///
/// Every rounding of a section is an error e of one of its sums, |e| <= u times the sum of what is added. It
/// passes a linear section P^-1 Q, P = a0 + a1 w + a2 w^2, Q = b0 + b1 w + b2 w^2 with a0 + a1 + a2 = 1,
/// through Q/P at `high`, and with m_ij = a_i b_j - a_j b_i through
///
///     of second order   band:  ((a0 + a1) Q + m20 w + m21 w^2)/P     its state:  (1 - w)/2 (m20 + m21 w)/P
///                       low:   (a0 Q + (1 + w)/2 (m10 + m20 w))/P    its state:  (1 - w)/2 (m10 + m20 w)/P
///     of first order    low:   b0                                    its state:  (1 - w)/2 m10/P
///
/// and then through the following sections, each by its certified l1 norm. The signals that the errors are in
/// proportion to are bounded in the same way, by l1 norms from the input and from the errors: a system s <= n
/// + u G M s, whose least solution is found by iteration and confirmed.
/// @param unit_roundoff  u: 2^-53 of double, 2^-24 of float
/// @param sample_rate  of the filter [Hz]
RecursionError recursion_error(const FilterPlan<DoubleDouble>&, double sample_rate, double unit_roundoff);

}  // namespace qerr
