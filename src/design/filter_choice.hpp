#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "qerr/filter/filter.hpp"

namespace qerr {

/// The low-passes among which a filter is chosen, and the limits that the choice keeps.
struct FilterRange {
  std::vector<std::string> families;
  std::vector<int> orders;
  double least_cutoff = 0, most_cutoff = 0;  ///< [Hz]
  std::optional<double> delay;               ///< highest group delay at 0 Hz [s]
  /// Largest tracking error |H/(j 2 pi f)^d - 1| for motion up to `band` [Hz].
  struct Tracking {
    double band = 0, at_most = 0;
  };
  std::optional<Tracking> tracking;
};

/// A low-pass within the limits.
struct FilterCandidate {
  std::string family;
  int order = 0;
  double cutoff = 0;  ///< [Hz]
  Filter filter;
  double h2 = 0;                   ///< ||H||_2 [1/s^d]
  double delay = 0;                ///< [s]
  std::optional<double> tracking;  ///< largest tracking error over the band, if there is one
};

/// The result of `filter_candidates`.
struct FilterScan {
  std::vector<FilterCandidate> candidates;     ///< by family, order and cut-off
  double least_delay = 0, least_tracking = 0;  ///< of all filters, whether within the limits or not
  bool any_true_gain = false;                  ///< whether one of them passes slow motion as it is
  std::size_t filters = 0;                     ///< that were looked at
};

/// Low-passes of a family and an order, at one cut-off.
/// @returns empty if the family has no such order or cut-off
std::optional<Filter> low_pass(const std::string& family, int order, double cutoff, int derivative,
                               double sample_rate);

/// All families, orders and cut-offs within the limits: cut-offs in steps of a twelfth of an octave, and,
/// where a limit divides two of them, its cut-off to six digits, by bisection.
///
/// Noise grows and delay and tracking error fall with the cut-off of a low-pass, so that the quietest one
/// within limits is at such an end; where a family's ripple spoils that, the steps are what is compared.
/// Without a limit of the tracking error those are left out that do not pass slow motion as it is
/// (`passes_slow_motion`): noise would shrink with the signal.
/// @param accepts  further limits
FilterScan filter_candidates(const FilterRange&, int derivative, double sample_rate,
                             const std::function<bool(const Filter&)>& accepts);

/// Largest tracking error for motion up to `band`, from a ten-thousandth of it.
double tracking_up_to(const Filter&, double band);

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
