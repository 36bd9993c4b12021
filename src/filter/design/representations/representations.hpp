#pragma once

#include <string>
#include <vector>

#include "filter/design/families/families.hpp"
#include "filter/design/polynomial.hpp"
#include "qerr/filter/family.hpp"
#include "qerr/filter/filter.hpp"

namespace qerr {

// One line per member of this folder; src/filter/design/family.cpp lists them.
FilterRepresentation coefficients_representation();
FilterRepresentation sections_representation();
FilterRepresentation zero_pole_gain_representation();
FilterRepresentation state_space_representation();
FilterRepresentation ros_transfer_function_representation();

/// The numbers of a list whose rows have one number each.
/// @throws Error (input; key[index]) where a row has another size
std::vector<double> flat(const Rows&, const std::string& key);

/// @throws Error (input; key[index]) unless all numbers are finite
void check_finite(const Rows&, const std::string& key);

/// The error of a filter that is not stable.
Error unstable(const std::string& key, double largest_modulus);

/// A factor u + v w of a numerator or denominator. Of a conjugate pair only one is listed; real factors have
/// im = 0.
struct LinearFactor {
  Complex1024 u;
  Complex1024 v;
  bool real() const { return u.im == 0 && v.im == 0; }
};

/// gain prod(above)/prod(below) as a filter. Real poles have sections of their own, so that equal ones remain
/// equal.
/// @pre the numerator's degree, pairs counted twice, is at most that of the denominator
Filter filter_from_factors(const Binary1024& gain, const std::vector<LinearFactor>& above,
                           const std::vector<LinearFactor>& below, double sample_rate, int derivative);

/// The product of two polynomials.
std::vector<Binary1024> times(const std::vector<Binary1024>&, const std::vector<Binary1024>&);

/// Stores in the filter a proven bound of its deviation from the specified b/a, ascending in z^-1.
/// @returns false when that exceeds 1e-13 of the H2 norm
/// @throws Error (input; key) when b/a is not proven to be stable
bool set_deviation(Filter&, const std::vector<Binary1024>& b, const std::vector<Binary1024>& a,
                   double largest_modulus, const std::string& key);

}  // namespace qerr
