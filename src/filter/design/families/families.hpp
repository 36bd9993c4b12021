#pragma once

#include <charconv>
#include <optional>
#include <string>
#include <vector>

#include "qerr/core/error.hpp"
#include "qerr/filter/family.hpp"

namespace qerr {

// One line per member of this folder; src/filter/design/family.cpp lists them.
FilterFamily first_order_family();
FilterFamily butterworth_family();
FilterFamily bessel_family();
FilterFamily chebyshev1_family();
FilterFamily chebyshev2_family();
FilterFamily elliptic_family();
FilterFamily exponential_moving_average_family();
FilterFamily finite_difference_family();
FilterFamily savitzky_golay_family();
FilterFamily least_squares_family();
FilterFamily kalman_family();
FilterFamily alpha_beta_family();
FilterFamily alpha_beta_gamma_family();
FilterFamily tracking_loop_family();

/// A number for a message, with at most 12 digits.
std::string figure(double value);

/// The whole number `key` of a design, `fallback` where absent.
/// @throws Error (input; key) unless it is whole and in [least, most]
int whole_number(const FilterDesign&, const std::string& key, int fallback, int least, int most);

/// The cut-off of a design [Hz].
/// @throws Error (input; key `cutoff`) unless 0 < cutoff < sample_rate/2
double checked_cutoff(const FilterDesign&);

/// The highest order of a low-pass.
inline constexpr int max_order = 20;

/// Parameter rows of several families.
Parameter order_row(int fallback);
Parameter cutoff_row(std::string_view meaning);
Parameter ripple_row();
Parameter attenuation_row(std::string_view meaning);

/// The number `key` of a design.
/// @throws Error (input; key) unless it is given (or `fallback` is) and lies above `above` and at most `most`
double checked_number(const FilterDesign&, const std::string& key, double above, double most,
                      std::optional<double> fallback = {});

/// The word `key` of a design, the first of `choices` where absent.
/// @throws Error (input; key) unless it is one of them
std::string checked_choice(const FilterDesign&, const std::string& key,
                           const std::vector<std::string>& choices);

/// Which of several alternative groups of parameters the design has.
/// @returns the index of the group all of whose keys are given, and none of the others
/// @throws Error (input; a key) that lists the groups
std::size_t parameter_group(const FilterDesign&, const std::vector<std::vector<std::string>>& groups);

/// @throws Error (input; key `sample_rate`) unless 0 < sample_rate < infinity
void check_sample_rate(double sample_rate);

/// @throws Error (input; key `derivative`) unless 0 <= derivative <= max_derivative
void check_derivative(int derivative);

/// @throws Error (input; key `derivative`) when the family cannot estimate the wanted derivative
void check_derivative(const FilterDesign&, int most, const std::string& rule);

}  // namespace qerr
