#pragma once

#include <array>
#include <optional>
#include <vector>

#include "qerr/filter/filter.hpp"

namespace qerr {

/// |H|/(2 pi f)^derivative near 0 Hz: 1 for a filter that estimates its derivative; huge when it passes a
/// lower one, tiny when it only passes higher ones.
double low_frequency_gain(const Filter&);

/// Whether that gain is 1 within a factor of two: ripple is allowed, a forgotten 1/T is not.
bool estimates_its_derivative(const Filter&);

/// How a filter estimates its derivative at one frequency, against the ideal (j 2 pi f)^derivative.
struct Fidelity {
  double frequency = 0;    ///< [Hz]
  double gain_error = 0;   ///< |H| / (2 pi f)^d - 1
  double phase_error = 0;  ///< arg H - d pi/2 [rad], in (-pi, pi]; negative: the estimate lags
  double tracking_error =
      0;  ///< |H / (j 2 pi f)^d - 1|: error of the estimate over the true derivative's amplitude
};

/// @param frequency_hz  above 0 and at most half the sample rate
Fidelity fidelity(const Filter&, double frequency_hz);

/// Error of the estimate for motion in a band: the price of the lag, to be set beside the noise.
struct BandTracking {
  double largest = 0;  ///< largest tracking error in the band
  double rms = 0;      ///< root mean square over the band, motion spread evenly over its frequencies
};

/// @pre 0 < from < to <= sample_rate/2 [Hz]
BandTracking band_tracking(const Filter&, double from, double to);

/// Lowest frequency at which |H|/(2 pi f)^d has fallen to 1/sqrt(2) of its value at 0 Hz [Hz]; empty when it
/// never does below half the sample rate, or has no value at 0 Hz (a filter that does not estimate its
/// derivative).
std::optional<double> bandwidth(const Filter&);

/// Width of the ideal band-limited derivative (j 2 pi f)^d, |f| < B, that passes as much white noise [Hz].
///
/// ||H||_2^2 = (2/f_s) (2 pi)^(2d) B^(2d+1)/(2d+1); for d = 0 and H(1) = 1 the usual equivalent noise
/// bandwidth.
double noise_bandwidth(const Filter&, double h2_norm);

/// Time after which the estimate of a derivative that is switched on stays within `fraction` of it [s]: the
/// response to t^d/d!, t >= 0, d the derivative. Empty when it does not settle there, or cannot be followed
/// (2e6 samples, or 2e5 steps of a slow filter).
std::optional<double> settling_time(const Filter&, double fraction = 0.02);

/// The filter as second-order sections {b0, b1, b2, 1, a1, a2} in ascending powers of z^-1, the gain in the
/// first one.
/// @pre the filter has no taps
std::vector<std::array<double, 6>> second_order_sections(const Filter&);

}  // namespace qerr
