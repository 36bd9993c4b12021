#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "qerr/core/parameter.hpp"
#include "qerr/encoder/encoder.hpp"

namespace qerr {

/// One effect of a spec, its values checked and in SI units.
struct Effect {
  std::string type;
  std::string joint;  ///< the independent joint it acts on
  std::map<std::string, double> numbers;
  std::map<std::string, std::string> choices;

  /// Value of a parameter: the given one, else the default of the effect's row, else 0.
  /// @throws std::out_of_range for a name that is neither given nor a parameter of the row
  double number(const std::string& name) const;

  /// The given value of a parameter, else `otherwise`: also for effects whose row has no such parameter.
  double number_or(const std::string& name, double otherwise) const {
    const auto found = numbers.find(name);
    return found == numbers.end() ? otherwise : found->second;
  }
};

/// Whether any parameter of an effect is not zero.
bool has_size(const Effect&);

/// Wave number of a periodic effect: phase of its sine per joint coordinate, the order times the signed ratio
/// of its shaft (the encoder's, or the joint's by the choice `shaft`) [rad/rad or rad/m].
/// @returns 0 for an effect without an order
double wave_number(const Effect&, const Encoder&);

/// Unit vector along which an effect of stage `kinematics` displaces its joint's origin, by its choice `axis`
/// in the axes of the joint's parent link.
/// @throws std::out_of_range for an effect without that choice
Eigen::Vector3d displacement_direction(const Effect&);

/// Shape of a residual that no effect of the catalogue has.
enum class Shape { step, hysteresis, exponential, line, order, bump, by_count, noise, unknown };

/// "step", "hysteresis", ...
std::string_view name(Shape);

/// Range, mean and mean square of a quantity over a motion.
struct Spread {
  double lower = 0, upper = 0, mean = 0, mean_square = 0;

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
};

/// Quantity of the usage without which a share cannot be computed.
enum class Need { nothing, position, velocity, effort, temperature, duration };

/// Power spectrum of an error, which determines the part that passes a filter.
enum class Spectrum {
  constant,  ///< constant over the filter's memory
  motion,    ///< that of a signal which the motion determines: unknown without one
  white      ///< independent from sample to sample
};

/// Error that an effect adds to its coordinate, estimate - true [rad or m].
///
/// The worst case grows by |mean| + half_width, the variance by sigma^2 (about the mean). A Gaussian is
/// unbounded; its half_width is four sigma (convention).
struct Share {
  double mean = 0, half_width = 0, sigma = 0;
  Spectrum spectrum = Spectrum::constant;
  double step_at_reversal = 0;  ///< by which the error jumps where the joint turns round, and only there
};

inline bool is_zero(const Share& s) { return s.mean == 0 && s.half_width == 0 && s.sigma == 0; }

}  // namespace qerr
