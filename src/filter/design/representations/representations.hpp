#pragma once

#include "filter/design/families/families.hpp"
#include "qerr/filter/family.hpp"

namespace qerr {

// One line per member of this folder; src/filter/design/representations.cpp lists them.
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

}  // namespace qerr
