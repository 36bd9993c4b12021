#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace qerr {

/// Range, mean and mean square of a quantity over a motion.
struct Spread {
  double lower = 0, upper = 0, mean = 0, mean_square = 0;
  /// Mean angular frequency: rms of the derivative over the rms about the mid-range [rad/s]; empty: unknown.
  std::optional<double> rate = {};

  double mid_range() const { return 0.5 * (lower + upper); }
  double half_width() const { return 0.5 * (upper - lower); }
  double largest() const { return std::max(std::abs(lower), std::abs(upper)); }
  double rms() const { return std::sqrt(mean_square); }

  /// Root mean square deviation from the mid-range c: sqrt(E[x^2] - 2 c E[x] + c^2).
  double rms_about_mid_range() const {
    return std::sqrt(std::max(0.0, mean_square + mid_range() * (mid_range() - 2 * mean)));
  }
};

/// Motion, load and temperature of a joint or of an encoder's coordinate: the quantities that effects depend
/// on. Empty: unknown.
struct Usage {
  std::optional<Spread> position;     ///< from the joint's zero [rad or m]
  std::optional<Spread> velocity;     ///< [rad/s or m/s]
  std::optional<Spread> effort;       ///< [N m or N]
  std::optional<Spread> temperature;  ///< rise since the start [K]
  std::optional<double> duration;     ///< [s]
  std::optional<double> reversals;    ///< pi times the reversals per second: angular frequency [rad/s]
  std::vector<double> speeds;         ///< equally probable velocities; empty: unknown [rad/s or m/s]
};

/// Quantity of the usage without which a share cannot be computed.
enum class Need { nothing, position, velocity, effort, temperature, duration };

/// Power spectrum of an error, which determines the part that passes a filter.
enum class Spectrum {
  constant,   ///< constant over the filter's memory
  motion,     ///< one line, at the mean angular frequency of the quantity that the error is proportional to
  reversals,  ///< of a square wave that changes sign at every reversal of the motion
  travel,     ///< periodic in the position: lines at the wave numbers times the speed
  white       ///< independent from sample to sample
};

/// A sinusoidal component of an error that is periodic in the position.
struct Sinusoid {
  double wave_number = 0;        ///< phase per joint coordinate [rad/rad or rad/m]
  double variance_fraction = 0;  ///< its part of the error's variance
};

/// Error that an effect adds to its coordinate, estimate - true [rad or m].
///
/// The worst case grows by |mean| + half_width, the variance by sigma^2 (about the mean). A Gaussian is
/// unbounded; its half_width is four sigma (convention).
struct Share {
  double mean = 0, half_width = 0, sigma = 0;
  Spectrum spectrum = Spectrum::constant;
  std::vector<Sinusoid> sinusoids = {};  ///< of `travel`; the remaining variance is treated as white
  std::optional<double> rate = {};       ///< of `motion` [rad/s]; empty: unknown
};

}  // namespace qerr
