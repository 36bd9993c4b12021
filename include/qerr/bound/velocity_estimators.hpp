#pragma once

#include <string>
#include <vector>

#include "qerr/effect/effect.hpp"

namespace qerr {

/// Bits of a sum at full precision: one more than a double has.
inline constexpr int full_bits = 54;

/// A quantized sine: x = offset + amplitude sin(phi), phi uniform, all in quanta (Delta = 1), rounded to
/// nearest, e = round(x) - x (paper, Appendix B, Eqs. 54 to 56).
///
/// With k = 1, 2, ...:
///   E e   = sum (-1)^k/(pi k)   sin(2 pi k offset) J_0(2 pi k amplitude)
///   E e^2 = 1/12 + sum (-1)^k/(pi k)^2 cos(2 pi k offset) J_0(2 pi k amplitude)
///
/// The terms fall only as k^-3/2 and k^-5/2, so the series are not summed. Up to amplitude 10 the integrals
/// between the crossings of the quantizer's thresholds are summed exactly (arc cosines); beyond, Hankel's
/// expansion of the Bessel functions is, whose sums over k are polylogarithms of half-integer order. Absolute
/// error below 1e-12.
/// @param offset, amplitude  [quanta]; finite, amplitude >= 0
/// @param bits  of the sum that are wanted beyond amplitude 10: fewer are faster
double quantized_sine_mean(double offset, double amplitude);
double quantized_sine_mean_square(double offset, double amplitude, int bits = full_bits);

/// The paper's envelopes over every offset: |E e| <= 0.135/sqrt(amplitude) (Eq. 55), and E e^2 - 1/12 between
/// -0.029/sqrt(amplitude) and 0.038/sqrt(amplitude) (Eq. 56). The figures are rounded: from amplitude 2
/// quanta on the largest mean is 0.1358/sqrt(amplitude), 0.6 % more.
///
/// Eq. 56 holds for the mean-square error. The paper states it of the difference of the variances of output
/// and input, R2, for which it is false: that contains 2 E e(x - offset), about 0.37 sqrt(amplitude).
struct SineEnvelope {
  double mean = 0;
  double mean_square_below = 0;
  double mean_square_above = 0;
};
SineEnvelope quantized_sine_envelope(double amplitude);

/// Where the edges of an encoder's disc lie, in intervals Delta; ideally every Delta.
struct EdgeErrors {
  double shortest = 1, longest = 1;  ///< distance of neighbouring edges
  double spread = 0;                 ///< largest difference of the displacements of two edges of a line
  double slope = 0;                  ///< largest |d error/d position| of the disc's slow errors

  bool ideal() const { return shortest == 1 && longest == 1; }
  bool operator==(const EdgeErrors&) const = default;
};

/// Of the effects of stages `disc` and `line` on a joint, such as `state_width` and `eccentricity`. Of a line
/// of more than 4096 edges 4096 neighbouring pairs are looked at.
EdgeErrors edge_errors(const Encoder&, const std::vector<Effect>&, const std::string& joint);

/// Largest |error| of a velocity computed from an encoder's counts [rad/s or m/s]; infinite: unbounded.
///
/// The error is against the mean velocity over the interval measured (paper, Eqs. 47 and 50).
struct EstimatorError {
  double printed = 0;   ///< the paper's bound, Eq. 48 (with its sign mended) or Eq. 52
  double varying = 0;   ///< least bound for any motion (FDM), any monotone one up to the speed (ITM)
  double constant = 0;  ///< least bound for a constant speed; 0 for whole counts per interval
};

/// Fixed time, FDM: (x_k - x_{k-1}) f. At V = v/(Delta f) counts per sample the difference is floor(V) or
/// ceil(V): constant Delta f max({V}, 1 - {V}), 0 for whole V; printed and varying Delta f.
/// @param resolution   Delta [rad or m], > 0
/// @param sample_rate  f [Hz], > 0
///
/// With a spread s of the edges and a slope e of the disc's error the difference is off by 1 + s counts and
/// e V: k counts lie between V (1 - e) - 1 - s and V (1 + e) + 1 + s.
/// @param speed        v [rad/s or m/s]; |v| is used
EstimatorError finite_difference_error(double resolution, double sample_rate, double speed,
                                       const EdgeErrors& = {});

/// Fixed distance, ITM: Delta over the time between two edges, which is measured in n whole ticks of a clock.
///
/// With alpha = Delta f_c/v ticks between edges (Eq. 51; v the largest speed between them) and m =
/// floor(alpha), a true duration tau >= alpha is measured as floor(tau) or ceil(tau): constant Delta f_c
/// max(1/m - 1/alpha, 1/alpha - 1/(m + 1)), 0 for whole alpha; varying Delta f_c/(m (m + 1)), a supremum;
/// printed Delta f_c/m, loose by m + 1. Infinite for alpha < 1, where two edges may share a tick.
///
/// A distance w Delta of the edges is taken for Delta: it lasts tau >= w alpha, and the largest errors are
/// Delta f_c (1/m - w/(m + 1)), m = floor(w alpha), of the shortest w, and Delta f_c max(1/alpha - 1/c, w/c -
/// 1/(c
/// + 1)), c = ceil(w alpha), of the longest: at every speed at least |1/w - 1| of it.
/// @param clock  f_c [Hz]: the paper's is the sample rate; a hardware timer is faster
/// @pre the velocity keeps its sign between the edges. Against the instantaneous velocity, which changes
/// while the joint moves on by Delta, no such bound exists.
EstimatorError inverse_time_error(double resolution, double clock, double speed, const EdgeErrors& = {});

/// The highest speed up to which ITM's error is never larger than FDM's, `varying` bounds [rad/s or m/s]:
/// Delta f_c/m, m the least integer with m (m + 1) >= f_c/f. With the clock at the sample rate this is Delta
/// f, the paper's Eqs. 45 and 46; with a fast one about Delta sqrt(f f_c). With errors of the edges found by
/// bisection.
double estimator_crossing(double resolution, double sample_rate, double clock, const EdgeErrors& = {});

/// Worst-case signal-to-noise ratio, 20 log10(|v|/error) (Eqs. 49 and 53) [dB]; plus infinity
/// for no error, minus infinity for an infinite one.
/// @pre v != 0
double worst_case_snr_db(double speed, double error);

}  // namespace qerr
