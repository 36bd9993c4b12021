#pragma once

#include "filter/design/families/families.hpp"

namespace qerr {

inline constexpr int max_window = 10000;
inline constexpr int max_polynomial_order = 20;

Parameter window_row();

/// The filter whose output is the derivative of the least-squares polynomial through the newest `window`
/// samples (Savitzky and Golay 1964), `back` samples before the newest one.
///
/// The fit is by orthogonal polynomials (discrete Chebyshev, also called Gram) with 256 bits, so that
/// each tap is rounded once.
/// @throws Error (input; key `sample_rate`, `derivative` or `polynomial_order`) unless derivative <=
/// polynomial_order < window
Filter polynomial_fit(const FilterDesign&, int window, int polynomial_order, double back);

}  // namespace qerr
