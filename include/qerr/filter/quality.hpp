#pragma once

#include <array>
#include <optional>
#include <vector>

#include "qerr/filter/filter.hpp"

namespace qerr {

/// H/(j 2 pi f)^derivative at 0 Hz: 1 for a filter that estimates its derivative, negative for one that
/// reverses the sign; infinite when it passes a lower derivative, 0 when it passes only higher ones.
double low_frequency_gain(const Filter&);

/// Whether low_frequency_gain is within a factor of two of 1: tolerates ripple, but not a missing 1/T.
bool estimates_its_derivative(const Filter&);

/// Whether low_frequency_gain is 1 within 1 %: filters compare by their noise only at equal gain.
bool passes_slow_motion(const Filter&);

/// How a filter estimates its derivative at one frequency, against the ideal (j 2 pi f)^derivative.
struct Fidelity {
  double frequency = 0;       ///< [Hz]
  double gain_error = 0;      ///< |H| / (2 pi f)^d - 1
  double phase_error = 0;     ///< arg H - d pi/2 [rad], in (-pi, pi]; negative: the estimate lags
  double tracking_error = 0;  ///< |H / (j 2 pi f)^d - 1|: error amplitude over that of the true derivative
};

/// @pre 0 < frequency_hz <= sample_rate/2
Fidelity fidelity(const Filter&, double frequency_hz);

/// Error of the estimate for motion in a frequency band: the counterpart of the noise, due to lag.
struct BandTracking {
  double largest = 0;  ///< largest tracking error in the band
  double rms = 0;      ///< root mean square over the band, for a flat spectrum of the motion
};

/// @pre 0 < from < to <= sample_rate/2 [Hz]
BandTracking band_tracking(const Filter&, double from, double to);

/// Lowest frequency at which |H|/(2 pi f)^d is 1/sqrt(2) of its value at 0 Hz [Hz]; empty if it never falls
/// below half the sample rate, or if the filter does not estimate its derivative.
std::optional<double> bandwidth(const Filter&);

/// Noise-equivalent bandwidth B [Hz]: the ideal band-limited derivative (j 2 pi f)^d, |f| < B, passes as much
/// white noise.
///
/// ||H||_2^2 = (2/f_s) (2 pi)^(2d) B^(2d+1)/(2d+1); the usual definition for d = 0 and H(1) = 1.
double noise_bandwidth(const Filter&, double h2_norm);

/// Settling time [s]: the response to t^d/d!, t >= 0, whose d-th derivative is 1, stays within `fraction` of
/// 1 from then on; d is the filter's derivative. Exact to a sample. Empty when it does not settle there, or
/// where close poles do not allow partial fractions and it takes more than 2e6 samples.
std::optional<double> settling_time(const Filter&, double fraction = 0.02);

/// The filter as second-order sections {b0, b1, b2, 1, a1, a2} in ascending powers of z^-1, the gain in the
/// first one.
/// @pre the filter has no taps
std::vector<std::array<double, 6>> second_order_sections(const Filter&);

}  // namespace qerr
