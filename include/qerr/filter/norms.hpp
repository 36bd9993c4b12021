#pragma once

#include <array>
#include <optional>
#include <vector>

#include "qerr/filter/filter.hpp"

namespace qerr {

/// lower <= value <= upper.
struct Interval {
  double lower = 0;
  double upper = 0;
};

/// |exact - value| <= error.
struct Estimate {
  double value = 0;
  double error = 0;
};

/// Norms of a filter [1/s^derivative].
struct Norms {
  double h2 = 0;        ///< ||H||_2, sigma of the output for white input of unit sigma (paper, Eq. 28)
  double h2_error = 0;  ///< bound of |h2 - ||H||_2|, including the rounding to double
  Interval l1;          ///< contains ||H||_1 = sum |h_k|, the peak for input bounded by 1 (Eq. 26)
  double dc_gain = 0;   ///< H(1)
};

/// ||H||_2 = sqrt(sum h_k^2) = sqrt((1/pi) int |H|^2 dOmega/(1 + Omega^2)), w = j Omega [1/s^derivative].
///
/// Astrom's recursion (Introduction to Stochastic Control Theory, 1970, ch. 5) on the polynomials in w, which
/// needs no controller canonical form and no Lyapunov equation. It runs in ball arithmetic
/// (multiprecision.hpp), in double-double first and with 1024 or 4096 bits where that does not prove 21
/// digits. So the value is the exact norm rounded to double, and the error a proven bound. For coefficients
/// given by the user the error includes the rounding of their factors (`Filter::deviation`), for a family's
/// design an allowance for the rounding of its coefficients, 1e-15 of the norm per section
/// (`Filter::designed`).
/// @pre every section is stable
/// @throws Error (input) when the norm or the gain is out of the range of double
Estimate h2_estimate(const Filter&);

/// The value of `h2_estimate`.
double h2_norm(const Filter&);

/// An interval that is proven to contain ||H||_1 = sum |h_k| [1/s^derivative], including rounding errors.
///
/// Fast filters are summed directly, in double-double with a running error bound (direct_sum.hpp). Slow ones
/// are expanded in partial fractions (modes.hpp): over a run of one sign, the sum of h is a difference of two
/// values of the step response, so that the work grows with the changes of sign and not with the filter's
/// memory (tail_sum.hpp). Poles near z = -1 or other roots of 1 change the sign at every sample; every n-th
/// sample, a sum of modes too, does not change it (decimation). Where samples are fewer than the work for
/// runs, they are summed in doubles (sampled_sum.hpp). Modes are dropped when they have decayed, and the
/// periods of a single remaining resonance, of which there may be billions, are summed by Euclid's algorithm
/// on their signs (resonance_sum.hpp). The truncated tail of a direct sum is bounded by Cauchy and Schwarz:
/// sum_{k>=K} |h_k| <= r^K (1 - r^2)^(-1/2) ||H(rz)||_2.
///
/// The relative width is below 4e-12 where the memory 1/(1 - |z|) is below a million samples, for poles near
/// the roots of 1 of equal degree up to 240, and where all modes but the slowest decay within a million
/// samples or some hundred thousand changes of sign, at any speed of the slowest. These are all families
/// except slow elliptic low-passes of order 17 and more (1 dB of ripple) or 19 and more (0.1 dB), and of 30
/// dB of ripple and more, whose slowest resonances ring for 10^4 periods and more. The interval is wider
/// there, and where several or repeated resonances, or a resonance and a real pole, share a longer memory:
/// then possibly only the order of magnitude is known. Computation takes about a second at most. A family's
/// interval includes the rounding of its coefficients, 1e-15 per section.
/// @pre every section is stable
Interval l1_norm(const Filter&);

/// All norms of a filter.
Norms norms(const Filter&);

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
