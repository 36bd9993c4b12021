#pragma once

namespace qerr {

/// A quantized sine: x = offset + amplitude sin(phi), phi uniform, all in quanta (Delta = 1), rounded to
/// nearest, e = round(x) - x (paper, Appendix B, Eqs. 54 to 56).
///
/// With k = 1, 2, ...:
///   E e   = sum (-1)^k/(pi k)   sin(2 pi k offset) J_0(2 pi k amplitude)
///   E e^2 = 1/12 + sum (-1)^k/(pi k)^2 cos(2 pi k offset) J_0(2 pi k amplitude)
///   E e (x - offset) = amplitude sum (-1)^k/(pi k) cos(2 pi k offset) J_1(2 pi k amplitude)
///
/// The terms fall only as k^-3/2 and k^-5/2, so the series are not summed. Up to amplitude 10 the integrals
/// between the crossings of the quantizer's thresholds are summed exactly (arc cosines); beyond, Hankel's
/// expansion of the Bessel functions is, whose sums over k are polylogarithms of half-integer order. Absolute
/// error below 1e-12 (times the amplitude for the correlation).
/// @param offset, amplitude  [quanta]; finite, amplitude >= 0
double quantized_sine_mean(double offset, double amplitude);
double quantized_sine_mean_square(double offset, double amplitude);
double quantized_sine_correlation(double offset, double amplitude);

/// Correlation of e with itself `lag` samples later, over random offset and phase, for cycles_per_sample
/// f_i/f: 1 - 6 E {s}(1 - {s}), where s is a sine of amplitude 2 amplitude |sin(pi lag f_i/f)| (paper, Eqs.
/// 57, 58).
///
/// The difference of two samples of a sine is a sine; for slow ones this is sum 6/(pi k)^2 J_0(2 pi k lag V)
/// with V = 2 pi amplitude f_i/f, the peak speed in quanta per sample.
double quantized_sine_autocorrelation(double amplitude, double cycles_per_sample, double lag);

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

}  // namespace qerr
