#pragma once

#include <optional>
#include <span>

#include "filter/norms/autocorrelation.hpp"

namespace qerr {

/// Standard deviation of an encoder's filtered quantization error in motion: what IPQN only assumes.
///
/// In units of Delta: the results times Delta are the sigma of the filter's output [rad/s, m/s, ...].
///
/// Two samples of the error whose positions differ by s quanta have, over a uniformly random position of the
/// encoder's zero, the covariance Delta^2/12 - Delta^2 {s}(1 - {s})/2, {.} the fractional part. Hence,
/// exactly,
///
///   sigma^2 / Delta^2 = H(1)^2/12 - sum_{n>=1} r_n E {s_n}(1 - {s_n}),
///
/// r the autocorrelation of the impulse response and s_n what the joint moves in n samples. That is one
/// formula for every speed: for an irrational number V of quanta per sample it is sum_k |H(e^{2 pi i k
/// V})|^2/(2 pi^2 k^2), for V = p/q it is sum_{m=1}^{q-1} |H(e^{2 pi i m p/q})|^2/(4 q^2 sin^2(pi m/q)), both
/// with the squared constant error H(1)^2/(12 q^2) (none at irrational V), and it is continuous in V: no
/// decision about the rationality of a double has to be made. For H(1) = 0 the result holds for every zero,
/// else it is the root mean square over the zero's position. `rounding: down` shifts the error by -Delta/2:
/// the deviation from that mean, whose share behind the filter is H(1), is the same.
///
/// The error of each result is that of r: |sigma^2 error| <= tail/4 + rounding, far below 1e-6 relative
/// unless sigma itself nearly vanishes.
/// @pre the filter has settled

/// At a constant speed of V quanta per sample (V = v/(Delta f)); even in V, with period 1. Exactly
/// |H(1)|/sqrt(12) at whole V, so zero for derivatives.
///
/// Depends on V mod 1 only: no constant speed is so high that IPQN holds; it is the root mean square over V.
double constant_speed_sigma(const Autocorrelation&, double quanta_per_sample);

/// The same for any filter: one that remembers too many samples is answered by its harmonics. Exact at speeds
/// p/q with q <= 2000; at others the first half million are summed and the rest is put in at its mean over V,
/// about 1e-6 of the variance of IPQN, which is an estimate and no bound.
double constant_speed_sigma(const Filter&, double quanta_per_sample);

/// Along a sine of the given amplitude [quanta] and frequency [cycles per sample], over random zero and
/// phase.
///
/// Exact, not quasi-stationary: s_n is a sine of amplitude 2 A |sin(pi n f_i/f)|.
double sine_sigma(const Autocorrelation&, double amplitude, double cycles_per_sample);

/// The limit of `sine_sigma` for slow sines of a given peak speed, V = 2 pi A f_i/f: s_n has the amplitude n
/// V.
double slow_sine_sigma(const Autocorrelation&, double peak_quanta_per_sample);

/// Along any path of the joint, sampled at the filter's rate, over random zero: the root mean square over the
/// samples from `first` on, E s_n being over the pairs of such a sample and the one n before it. Exact when
/// `first` is at least the filter's memory; lags that reach back beyond the path count as uncorrelated. Very
/// long work (2e8 pairs) is thinned out evenly.
/// @param positions  [quanta], more than `first`
double path_sigma(const Autocorrelation&, std::span<const double> positions, std::size_t first = 0);

/// sigma under IPQN, ||H||_2/sqrt(12).
double ipqn_sigma(const Autocorrelation&);

/// The longest memory with which `ipqn_threshold` searches [samples].
inline constexpr std::size_t longest_threshold_search = 20000;

/// The peak speed of slow sines [quanta per sample] above which `slow_sine_sigma` stays within a fraction
/// `tolerance` of IPQN; 0 when it always does, empty when the filter remembers more than
/// `longest_threshold_search` samples, where the search would take seconds.
///
/// A bound of the Bessel series gives a speed above which there is none outside. Below, sigma^2/sigma_IPQN^2
/// - 1 of fast sines is a function of V mod 1 over sqrt(V), which locates the last crossing; it is then found
/// on the exact function, on a grid that is finest at whole V, where the narrow excursions are. Takes
/// milliseconds for a memory of 100 samples and seconds for 1e5. Of constant speeds there is no such
/// threshold.
/// @pre 0 < tolerance < 1
std::optional<double> ipqn_threshold(const Autocorrelation&, double tolerance);

}  // namespace qerr
