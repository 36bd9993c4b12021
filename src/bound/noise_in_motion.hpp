#pragma once

#include <optional>

#include "filter/norms/autocorrelation.hpp"
#include "qerr/bound/velocity_estimators.hpp"

namespace qerr {

/// Standard deviation of an encoder's filtered quantization error in motion, without the assumption IPQN.
///
/// In units of Delta: multiplied by Delta the results are sigma of the filter's output [rad/s, m/s, ...].
///
/// Over a uniformly random position of the encoder's zero, two samples of the error at positions s quanta
/// apart have the covariance Delta^2/12 - Delta^2 {s}(1 - {s})/2, {.} the fractional part. Hence, exactly,
///
///   sigma^2 / Delta^2 = H(1)^2/12 - sum_{n>=1} r_n E {s_n}(1 - {s_n}),
///
/// with r the autocorrelation of the impulse response and s_n the displacement in n samples [quanta]. For an
/// irrational number V of quanta per sample this equals sum_k |H(e^{2 pi i k V})|^2/(2 pi^2 k^2), for V = p/q
/// sum_{m=1}^{q-1} |H(e^{2 pi i m p/q})|^2/(4 q^2 sin^2(pi m/q)) + H(1)^2/(12 q^2); it is continuous in V, so
/// that a double need not be classified as rational or not. For H(1) = 0 the result holds for every zero,
/// otherwise it is the root mean square over the zero's position. `rounding: down` shifts the error by
/// -Delta/2 and leaves the deviation from the mean unchanged.
///
/// The error of each result is that of r: |error of sigma^2| <= tail/4 + rounding, far below 1e-6 relative
/// unless sigma itself nearly vanishes.
/// @pre the filter is in steady state

/// At a constant speed of V quanta per sample (V = v/(Delta f)); even in V, with period 1. Exactly
/// |H(1)|/sqrt(12) at whole V, so zero for derivatives.
///
/// Depends on V mod 1 only, so that IPQN does not hold at high constant speeds either; it is the root mean
/// square over V.
double constant_speed_sigma(const Autocorrelation&, double quanta_per_sample);

/// Sigma at constant speed behind any filter. Filters with too long a memory are computed from harmonics:
/// exact at speeds p/q with q <= 2000; otherwise the first 500 000 are summed and the remainder, about 1e-6
/// of the variance of IPQN, is replaced by its mean over V (an estimate, not a bound).
double constant_speed_sigma(const Filter&, double quanta_per_sample);

/// Along a sine of the given amplitude [quanta] and frequency [cycles per sample], over random zero and
/// phase.
///
/// Exact, not quasi-stationary: s_n is a sine of amplitude 2 A |sin(pi n f_i/f)|.
double sine_sigma(const Autocorrelation&, double amplitude, double cycles_per_sample);

/// The limit of `sine_sigma` for slow sines of a given peak speed, V = 2 pi A f_i/f: s_n has the amplitude n
/// V.
/// @param bits  as of quantized_sine_mean_square
double slow_sine_sigma(const Autocorrelation&, double peak_quanta_per_sample, int bits = full_bits);

/// sigma under IPQN, ||H||_2/sqrt(12).
double ipqn_sigma(const Autocorrelation&);

/// Longest filter memory for which `ipqn_threshold` searches [samples]; longer ones would take seconds.
inline constexpr std::size_t longest_threshold_search = 20000;

/// The peak speed of slow sines [quanta per sample] above which `slow_sine_sigma` stays within a fraction
/// `tolerance` of IPQN; 0 if it always does, empty if the filter's memory exceeds `longest_threshold_search`.
///
/// A bound of the Bessel series gives a speed above which the tolerance holds. Below it, sigma^2/sigma_IPQN^2
/// - 1 of fast sines is a function of V mod 1 divided by sqrt(V), which locates the last crossing; the
/// crossing is then computed on the exact function, on a grid that is finest at integer V, where the
/// excursions are narrow. Takes milliseconds for a memory of 100 samples and seconds for 1e5. Constant speeds
/// have no such threshold.
/// @pre 0 < tolerance < 1
std::optional<double> ipqn_threshold(const Autocorrelation&, double tolerance);

}  // namespace qerr
