#pragma once

#include <vector>

#include "filter/design/families/families.hpp"
#include "qerr/core/double_double.hpp"

namespace qerr {

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
