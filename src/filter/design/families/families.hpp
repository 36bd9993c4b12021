#pragma once

#include <optional>
#include <string>
#include <vector>

#include "filter/norms/multiprecision.hpp"
#include "qerr/core/double_double.hpp"
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

/// An analog low-pass with its cut-off at 1 rad/s.
struct Prototype {
  std::vector<ComplexDoubleDouble> poles;  ///< real ones and, of each pair, the upper one
  std::vector<DoubleDouble> zeros;         ///< b of each pair +-jb
  DoubleDouble gain = 1;                   ///< at 0 Hz
};

/// The section 1/((1 - x/p)(1 - x/p*)), or 1/(1 - x/p) for a real p, at x = slope * w.
Section section_of_pole(ComplexDoubleDouble p, DoubleDouble slope);

/// 1/rho of the pre-warped bilinear transform, rho = tan(pi cutoff/rate).
DoubleDouble prewarped_slope(double cutoff, double rate);

/// 10^(-decibels/20).
DoubleDouble attenuated(double decibels);

// The coefficients of a design are rounded to double-double, not to double: far below its cut-off the
// response of a low-pass is 1 up to the last digits of these.
using Real = Binary256;
Real asinh(const Real&);

/// The differences of the derivative, then the prototype at s = w/rho, rho = tan(pi f0 T): the bilinear
/// transform, pre-warped so that the prototype's 1 rad/s is exactly at f0. No polynomial is expanded in z, so
/// that the accuracy does not depend on f0 T.
/// @throws Error (input; key `cutoff` or `derivative`)
Filter bilinear_lowpass(const FilterDesign&, const Prototype&);

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

/// Parameter rows of the tracking filters.
Parameter tracking_index_row();
Parameter position_gain_row();
Parameter velocity_gain_row();

/// The denominator c0 + c1 w + ... of a steady-state Kalman filter for two (constant velocity) or three
/// (constant acceleration) integrators, c0 > 0.
///
/// It is the stable spectral factor of the measured process: c(w) c(-w) = p0 + p1 y + p2 y^2 + p3 y^3 at
/// y = -w^2, the spectrum of process and measurement noise over that of the measurement noise, times the
/// integrators' denominator. In w all p are positive, and so is each term of c1^2 = p1 + 2 c0 c2,
/// c2^2 = p2 + 2 c1 c3: there is no cancellation and no Riccati equation.
/// @param p  3 numbers for constant velocity, 4 for constant acceleration
std::vector<DoubleDouble> spectral_factor(const std::vector<DoubleDouble>& p);

/// Noise constant over each sample, G = [T^2/2, T] (Kalata 1984) or [T^2/2, T, 1] (Gray and Murray 1993).
/// @param index  Lambda = T^2 sigma_process/sigma_measurement
std::vector<DoubleDouble> piecewise_noise(int states, double index);

/// White acceleration (two states) or white jerk (three).
/// @param ratio  sqrt(q T^3)/sigma, or sqrt(q T^5)/sigma, of the intensity q and the measurement's sigma
std::vector<DoubleDouble> continuous_noise(int states, double ratio);

/// The transfer function from the measurement to the `derivative`-th state of x_hat(k|k), for the gains
/// alpha, beta/T and gamma/(2 T^2) whose characteristic polynomial is c.
///
/// Two states: beta + 2 alpha w + (4 - 2 alpha - beta) w^2 proportional to c; three: gamma/2 + 2 beta w +
/// (4 alpha - gamma/2) w^2 + (8 - 4 alpha - 2 beta) w^3.
/// @throws Error (input; key `derivative` or `sample_rate`)
Filter tracking_filter(const FilterDesign&, std::vector<DoubleDouble> c);

}  // namespace qerr
