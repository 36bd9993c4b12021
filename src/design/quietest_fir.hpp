#pragma once

#include <cstddef>
#include <vector>

namespace qerr {

/// A filter with `taps` taps that estimates a derivative.
struct FirTask {
  std::size_t taps = 0;
  int derivative = 0;      ///< d
  double sample_rate = 0;  ///< [Hz]
  double band = 0;         ///< highest frequency of the motion [Hz], below half the sample rate
  double tracking = 0;     ///< e, the largest tracking error, in (0, 1)
  double gain = 1;         ///< g of slow motion, within e of 1
};

/// The solution of `quietest_fir`.
struct QuietestFir {
  std::vector<double> h;  ///< impulse response [1/s^d]
  double h2 = 0;          ///< ||h||_2 [1/s^d]
  /// No filter with as many taps and this tracking error has a smaller ||h||_2: by weak duality, for any
  /// multipliers, up to rounding.
  double h2_bound = 0;
  double tracking =
      0;  ///< largest tracking error of h at the frequencies tested; at most 1.001 e if converged
  bool converged = false;
};

/// The linear filter with the least white noise whose tracking error stays within e over a band:
///   minimize ||h||_2^2 subject to |H(j 2 pi f)/(j 2 pi f)^d - 1| <= e for 0 < f <= band,
/// a convex quadratic programme with infinitely many linear constraints
///   Re e^{-j phi} (H/(j 2 pi f)^d - 1) <= e for all f and phi.
///
/// and H/(j 2 pi f)^d = g at 0 Hz: a filter that shrinks slow motion shrinks its noise with it. The first d
/// moments of h are 0, and the next is (-1)^d d! g. Within that affine subspace the programme is solved from
/// its dual, min |A^T l|^2/2 + b^T l over l >= 0, by an active set (Lawson and Hanson, Solving Least Squares
/// Problems, 1974, ch. 23); the constraints that the solution violates most, at local maxima of the tracking
/// error over frequency, are added until none is violated by more than a thousandth of e. Between the tested
/// frequencies, eight in each lobe of the taps, the error may be larger by about 1 %.
QuietestFir quietest_fir(const FirTask&);

}  // namespace qerr
