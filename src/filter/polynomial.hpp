#pragma once

#include <vector>

#include "qerr/core/double_double.hpp"

namespace qerr {

/// A polynomial in q = z^-1 with its zeros at q = 1 divided out: c(q) = (1 - q)^zeros * rest(q).
struct Deflated {
  int zeros = 0;
  std::vector<Wide> rest;
};

/// Divides out the zeros at q = 1 that the rounded coefficients cannot tell from exact ones.
///
/// 0.1 + 0.2 q - 0.3 q^2 sums to 2.8e-17 and not to 0; a filter so written is meant to block 0 Hz.
Deflated divide_out_dc_zeros(const std::vector<double>& ascending);

/// Sum of the coefficients: the value at q = 1.
Wide sum(const std::vector<Wide>& coefficients);

/// All roots of c0 z^n + c1 z^(n-1) + ... + cn, c0 and cn not 0, in conjugate pairs (Aberth's iteration in
/// double-double).
///
/// The coefficients are taken as exact. Pairs stand next to each other, upper half plane first; real roots
/// have im = 0.
std::vector<WideComplex> roots(const std::vector<Wide>& descending);

}  // namespace qerr
