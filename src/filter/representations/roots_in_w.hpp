#pragma once

#include <vector>

#include "qerr/core/double_double.hpp"
#include "qerr/filter/filter.hpp"

namespace qerr {

/// The factor u + v w of a numerator or denominator. Of a conjugate pair only one is listed; real factors
/// have im = 0.
struct LinearFactor {
  WideComplex u;
  WideComplex v;
  bool real() const { return u.im == Wide(0) && v.im == Wide(0); }
};

/// gain prod(above)/prod(below) as a filter: real poles in sections of their own, so that equal ones stay
/// equal.
/// @pre the numerator's degree, pairs counted twice, is at most that of the denominator
Filter filter_from_factors(Wide gain, std::vector<LinearFactor> above, std::vector<LinearFactor> below,
                           double sample_rate, int derivative);

}  // namespace qerr
