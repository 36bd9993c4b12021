#pragma once

#include <vector>

#include "filter/design/representations/representations.hpp"
#include "qerr/filter/filter.hpp"

namespace qerr {

/// A polynomial in w = (1 - z^-1)/(1 + z^-1), ascending.
using PolynomialInW = std::vector<Binary1024>;

/// A transfer function b(w)/a(w) with 1024 bits, so that sums and products of filters keep the digits of
/// their slow poles. Both have the size order + 1: a missing leading coefficient is a root at z = -1.
struct TransferRatio {
  PolynomialInW b, a;
};

/// sum c_k z^-k times (1 + w)^n, n its degree: a polynomial in w.
PolynomialInW in_w(const std::vector<Binary1024>& ascending_in_delays);

/// b(z^-1)/a(z^-1), ascending coefficients.
TransferRatio ratio_of_delays(std::vector<Binary1024> b, std::vector<Binary1024> a);

/// The filter, with its gain.
TransferRatio ratio_of(const Filter&);

PolynomialInW sum(const PolynomialInW&, const PolynomialInW&);
/// Sets coefficients to 0 that are 0 within the rounding of 1024 bits: they would add spurious roots.
void remove_rounding(PolynomialInW&);

/// A polynomial in w as lead w^k prod(1 - w/r): real factors and one of each conjugate pair; roots that agree
/// to 28 digits are one multiple root.
struct Factored {
  Binary1024 lead;
  std::vector<LinearFactor> factors;
  std::vector<Complex1024> roots;
};

/// @pre not 0
Factored factored(PolynomialInW);

/// The largest |z| of the roots in w.
/// @param uncertainty  of |z|
/// @param stable  set to whether all |z| < 1 - uncertainty
double largest_modulus(const std::vector<Complex1024>& roots_in_w, double uncertainty, bool& stable);

/// Divides by w while both polynomials have a root at w = 0, z = 1.
void cancel_at_dc(TransferRatio&);

/// Whether all poles are inside the unit circle by more than `uncertainty`, common roots at z = 1 left out.
bool is_stable(TransferRatio, double uncertainty);

/// A stable ratio as a filter, common roots at z = 1 left out. Multiple roots are found slowly; so known ones
/// can be given.
/// @param more   further factors of the numerator
/// @param poles  the factors of the denominator; null: not known
Filter filter_of(TransferRatio, double sample_rate, const std::vector<LinearFactor>& more = {},
                 const Factored* poles = nullptr);

/// The factors of the filter's denominator, from its sections. @pre no taps
Factored poles_of(const Filter&);

}  // namespace qerr
