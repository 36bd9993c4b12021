#pragma once

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

}  // namespace qerr
