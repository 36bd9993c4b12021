#pragma once

#include <vector>

#include "filter/norms/ball.hpp"
#include "filter/norms/complex.hpp"

namespace qerr {

using Complex1024 = ComplexOf<Binary1024>;

/// All roots of c0 z^n + c1 z^(n-1) + ... + cn, c0 and cn not 0, in conjugate pairs, by Ehrlich's and
/// Aberth's iteration: in double until that settles, then with 1024 bits.
///
/// Pairs stand next to each other, upper half plane first; real roots have im = 0. Simple roots come out to
/// hundreds of digits; an m-fold one as m roots on a ring of relative radius 2^(-1000/m), whose product is as
/// good as that of simple ones. Nothing is proven here: whoever needs a proof multiplies out again.
std::vector<Complex1024> roots(const std::vector<Binary1024>& descending);

long double magnitude(const Complex1024&);

}  // namespace qerr
