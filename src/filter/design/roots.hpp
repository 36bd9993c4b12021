#pragma once

#include <vector>

#include "filter/norms/ball.hpp"
#include "filter/norms/complex.hpp"

namespace qerr {

using Complex1024 = ComplexOf<Binary1024>;

/// All roots of c0 z^n + c1 z^(n-1) + ... + cn, c0 and cn not 0, by the iteration of Ehrlich and Aberth: in
/// double until that converges, then with 1024 bits.
///
/// Conjugate pairs are adjacent, upper half plane first; real roots have im = 0. Simple roots have hundreds
/// of correct digits; an m-fold one becomes m roots on a circle of relative radius 2^(-1000/m), whose product
/// is as accurate as that of simple ones. Nothing is proven: callers that need a proof multiply the factors
/// out.
std::vector<Complex1024> roots(const std::vector<Binary1024>& descending);

long double magnitude(const Complex1024&);

}  // namespace qerr
